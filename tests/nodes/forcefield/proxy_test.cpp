// forcefield.proxy: what it sends, what it goes through, and what it refuses.
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <limits>

#include "framework/core/segment.hpp"
#include "nodes/forcefield/proxy.hpp"
#include "tests/nodes/forcefield/field_scenes.hpp"
#include "tests/support/dice.hpp"
#include "tests/support/heap_is_counted.hpp"

BOOST_AUTO_TEST_SUITE(proxy_test)

using namespace tactor;
using namespace tactor::test;

namespace {

ProxyForceField::Params params() {
  auto p = default_params<ProxyForceField>();
  p.stiffness = 400;
  return p;
}

struct Rig : FieldRig<ProxyForceField> {
  explicit Rig(const ProxyForceField::Params& p = params(), const Scene& s = floor_and_ball()) : FieldRig(p, s) {}
  bool step(double ms) {
    node.force.clear_pending();
    node.state.clear_pending();
    return FieldRig::step(ms);
  }
};

/// How far rounding and the point's own size may put a force off, N.
constexpr double tiny_force = 400 * 2e-7;

}  // namespace

BOOST_AUTO_TEST_CASE(the_ball_of_the_tool_is_pushed_by_the_spring) {
  Rig rig;  // a ball of 10 mm
  BOOST_TEST(!rig.step(0));
  rig.device(1, {0, 0, 0.012});
  BOOST_TEST(rig.step(1));
  BOOST_TEST(norm(rig.shown()) == 0.0);
  rig.device(2, {0, 0, 0.007});
  BOOST_TEST(rig.step(3));
  BOOST_TEST(norm(rig.shown() - Vec3{0, 0, 400 * 0.003}) < tiny_force);
  BOOST_TEST(rig.last.stamp.valid.ns == stamp_ms(2).valid.ns);
  BOOST_TEST(norm(sent(rig.node.force).force - rig.shown()) == 0.0);
  const PhysicsState& state = sent(rig.node.state);
  BOOST_TEST(norm(state.X_WT.p - Vec3{0, 0, 0.010}) < 1e-6);
  BOOST_TEST(state.contacts == 1);
  BOOST_TEST(norm(state.contact_T_W.force - rig.shown()) == 0.0);
  // Without a new sample there is nothing to say.
  BOOST_TEST(!rig.step(4));
}

BOOST_AUTO_TEST_CASE(a_point_leaves_the_shape_of_the_tool_out) {
  auto p = params();
  p.probe = ProxyForceField::Probe::point;
  Rig rig(p);
  rig.device(0, {0, 0, 0.001});
  rig.step(0);
  BOOST_TEST(norm(rig.shown()) == 0.0);
  rig.device(1, {0, 0, -0.002});
  rig.step(1);
  BOOST_TEST(norm(rig.shown() - Vec3{0, 0, 0.8}) < tiny_force);
}

BOOST_AUTO_TEST_CASE(seldom_steps_show_what_steps_at_every_sample_show) {
  Rig often, seldom;
  Dice dice(2);
  Vec3 p{0, 0, 0.02};
  for (int ms = 0; ms < 400; ++ms) {
    p += dice.in_cube(4e-4) + Vec3{1e-4, 0, ms < 100 ? -1.5e-4 : 0};
    often.device(ms, p);
    seldom.device(ms, p);
    often.step(ms);
    if (ms % 20 != 19) continue;
    seldom.step(ms);
    BOOST_TEST(norm(seldom.shown() - often.shown()) == 0.0);
  }
  BOOST_TEST(norm(often.shown()) > 0.0);
}

BOOST_AUTO_TEST_CASE(the_damper_acts_along_the_push_and_never_pulls) {
  auto p = params();
  p.damping = 5;
  Rig rig(p);
  int ms = 0;
  const auto shown = [&](double z, const Vec3& v) {
    DeviceState state;
    state.X_WD.p = {0, 0, z};
    state.V_WD.v = v;
    rig.node.device.push(stamp_ms(++ms), &state);
    rig.step(ms);
    return rig.shown();
  };
  BOOST_TEST(norm(shown(0.02, {0, 0, -1})) == 0.0);
  BOOST_TEST(norm(shown(0.008, {0.3, 0.2, -0.1}) - Vec3{0, 0, 400 * 0.002 + 5 * 0.1}) < tiny_force);
  BOOST_TEST(norm(shown(0.008, {0, 0, 0.1}) - Vec3{0, 0, 400 * 0.002 - 5 * 0.1}) < tiny_force);
  BOOST_TEST(norm(shown(0.008, {0, 0, 1})) < tiny_force);
  BOOST_TEST(norm(shown(0.008, {std::nan(""), 0, 1}) - Vec3{0, 0, 400 * 0.002}) < tiny_force);
}

BOOST_AUTO_TEST_CASE(the_force_is_shortened_to_the_largest) {
  auto p = params();
  p.force_max = 2;
  Rig rig(p);
  rig.device(0, {0, 0, 0.02});
  rig.step(0);
  rig.device(1, {0, 0, -0.5});
  rig.step(1);
  BOOST_TEST(std::abs(norm(rig.shown()) - 2) < 1e-12);
}

BOOST_AUTO_TEST_CASE(what_is_not_finite_or_late_is_left_out_and_counted) {
  Rig rig;
  const double inf = std::numeric_limits<double>::infinity();
  rig.device(0, {0, 0, 0.02});
  rig.device(1, {0, 0, 0.005});
  rig.step(1);
  const Vec3 before = rig.shown();
  rig.device(2, {inf, 0, 0});
  rig.device(3, {0, std::nan(""), 0});
  rig.device(0.5, {0, 0, -0.1});
  BOOST_TEST(!rig.step(3));
  BOOST_TEST(metrics_of(rig.node)["proxy.rejected_samples"] == 3.0);
  rig.device(4, {0, 0, 0.005});
  BOOST_TEST(rig.step(4));
  BOOST_TEST(norm(rig.shown() - before) == 0.0);
}

BOOST_AUTO_TEST_CASE(no_step_calls_the_heap, *boost::unit_test::precondition(tactor::test::heap_is_counted)) {
  BOOST_TEST(ProxyForceField::declare().realtime_safe);
  Rig rig;
  Dice dice(3);
  for (int ms = 0; ms < 20; ++ms) rig.device(ms, dice.in_cube(0.02)), rig.step(ms);
  const std::int64_t before = thread_heap_calls();
  for (int ms = 20; ms < 1000; ++ms) rig.device(ms, dice.in_cube(0.02)), rig.step(ms);
  BOOST_TEST(thread_heap_calls() - before == 0);
}

BOOST_AUTO_TEST_CASE(what_it_cannot_render_is_refused_with_a_way_out) {
  Scene box = floor_and_ball();
  box.bodies[1].shape = BoxShape{{0.01, 0.01, 0.01}};
  std::string error = input_error([&] { ProxyForceField node(params(), context_for(box)); });
  BOOST_TEST(error.find("set probe: point") != std::string::npos, error);
  auto point = params();
  point.probe = ProxyForceField::Probe::point;
  BOOST_TEST(input_error([&] { ProxyForceField node(point, context_for(box)); }).empty());
  Scene two = floor_and_ball();
  two.bodies.push_back(field_body("other", SphereShape{0.01}, Motion::translation));
  error = input_error([&] { ProxyForceField node(params(), context_for(two)); });
  BOOST_TEST(error.find("forcefield.proxy") != std::string::npos, error);
}

BOOST_AUTO_TEST_SUITE_END()
