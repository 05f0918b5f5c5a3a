// The passivity observer: what a closed system generates, what a plane that jumps does, and how that is taken out.
#include <boost/test/unit_test.hpp>

#include "nodes/dynamics/passivity.hpp"
#include "nodes/dynamics/rigid.hpp"
#include "nodes/dynamics/translation.hpp"
#include "tests/nodes/dynamics/node_rig.hpp"
#include "tests/nodes/physics/mechanics/one_body.hpp"
#include "tests/support/nodes.hpp"

BOOST_AUTO_TEST_SUITE(energy_test)

using namespace tactor;
using namespace tactor::test;
namespace tt = boost::test_tools;

BOOST_AUTO_TEST_CASE(a_closed_system_generates_nothing_but_rounding) {
  OneBody t(block(0.1));
  t.coupling = spring(500, 0.1, 0.1);
  t.contacts = {floor_at({}, 0.001, 5e4, 0.5, 0.4), floor_at({}, -0.002, 800, 0, 0)};
  t.X().p = {0.002, 0, 0.01};
  t.V().v = {0.5, 0.2, -2};
  PassivityObserver observer;
  double last = t.energy();
  const double first = last;
  for (int i = 0; i < 5000; ++i) {
    t.advance(5e-4);
    observer.observe(t.energy() - last, 0, 1e9);
    last = t.energy();
  }
  BOOST_TEST(observer.generated() < 1e-12 * first);
  BOOST_TEST(observer.dissipated() == first - last, tt::tolerance(1e-9));
}

BOOST_AUTO_TEST_CASE(what_rotation_generates_vanishes_with_the_sub_step) {
  std::vector<double> generated;
  for (const double h : {1e-3, 1e-4}) {
    OneBody t(block(0.1, true));
    t.coupling = spring(500, 0.1, 0.1);
    for (const double x : {-0.02, 0.03}) t.contacts.push_back(floor_at({x, 0.01, -0.01}, 0.001, 2e4, 0.1, 0.3));
    t.V() = {{0.5, 0.2, -1}, {20, -30, 10}};
    PassivityObserver observer;
    double last = t.energy();
    const double first = last;
    for (int i = 0; i < static_cast<int>(0.5 / h); ++i) {
      t.advance(h);
      observer.observe(t.energy() - last, 0, 1e9);
      last = t.energy();
    }
    generated.push_back(observer.generated() / first);
  }
  BOOST_TEST(generated[0] < 0.02);
  BOOST_TEST(generated[1] < 0.2 * generated[0] + 1e-12);
}

BOOST_AUTO_TEST_CASE(the_work_of_the_handle_is_what_the_spring_stores) {
  OneBody t(block(0.1));
  t.coupling.k_t = 500;
  DeviceState a, b;
  a.X_WD.p = {0.010, 0, 0};
  b.X_WD.p = {0.011, 0, 0};
  SystemModel m = block(0.1);
  m.gravity_W = {};
  const double before = system_energy(m, t.coupling, a, {}, t.bodies).spring;
  const double after = system_energy(m, t.coupling, b, {}, t.bodies).spring;
  BOOST_TEST(before == 0.5 * 500 * 1e-4, tt::tolerance(1e-12));
  // The force at the end, times the way: more than the spring stores by k dx^2 / 2.
  BOOST_TEST(handle_work(m, t.coupling, a, b, t.bodies) - (after - before) == 0.5 * 500 * 1e-6, tt::tolerance(1e-9));
}

namespace {

/// A tool in space that a plane jumps onto, 1 mm deep, while the handle holds still and slack.
double total_after_jump(bool dissipate, std::map<std::string, double>& metrics) {
  TranslationDynamics::Params p = default_params<TranslationDynamics>();
  p.dissipate_above = dissipate ? 0 : 1e6;
  // The energy leaves at rest, by a share of h^2 k / m a sub-step.
  p.substep = dissipate ? 1e-3 : 1e-4;
  const int end = dissipate ? 1000 : 100;
  NodeRig<TranslationDynamics> rig(p, Motion::translation);
  rig.coupling = {.k_t = 1e-6, .force_max = 8};
  rig.push_law();
  ContactSet none, jump;
  none.bodies.count = jump.bodies.count = 1;
  jump.count = 1;
  jump.contact[0] = floor_at({}, -0.001, 2000, 0, 0);
  for (int ms = 0; ms <= 5; ++ms) rig.device(ms, {});
  rig.contacts(5, none);
  BOOST_REQUIRE(rig.step(5) == 1U);
  for (int ms = 6; ms <= end; ++ms) rig.device(ms, {});
  rig.contacts(end, jump);
  BOOST_REQUIRE(rig.step(end) == 1U);
  metrics = rig.metrics();
  // Pushed out, or all but.
  BOOST_TEST(rig.state().X_WT.p.z > 0.00099);
  return 0.5 * 0.1 * dot(rig.state().V_WT.v, rig.state().V_WT.v);
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_plane_that_jumps_by_d_generates_half_k_d_squared) {
  std::map<std::string, double> metrics;
  const double kinetic = total_after_jump(false, metrics);
  BOOST_TEST(metrics["dynamics_energy_generated_J"] == 0.5 * 2000 * 1e-6, tt::tolerance(1e-9));
  BOOST_TEST(metrics["dynamics_energy_generated_max_J"] == 0.5 * 2000 * 1e-6, tt::tolerance(1e-9));
  BOOST_TEST(kinetic == 0.5 * 2000 * 1e-6, tt::tolerance(0.05));  // less the numerical damping
}

BOOST_AUTO_TEST_CASE(dissipate_takes_what_was_generated_out_of_the_velocity) {
  std::map<std::string, double> metrics;
  const double kinetic = total_after_jump(true, metrics);
  BOOST_TEST(metrics["dynamics_energy_generated_J"] == 0.5 * 2000 * 1e-6, tt::tolerance(1e-6));
  BOOST_TEST(kinetic < 1e-9);
  // Taken, or dissipated by the sub-steps before it could be.
  BOOST_TEST(metrics["dynamics_energy_taken_J"] > 0.4 * 0.5 * 2000 * 1e-6);
  BOOST_TEST(metrics["dynamics_energy_taken_J"] + metrics["dynamics_energy_dissipated_J"] == 0.5 * 2000 * 1e-6,
             tt::tolerance(1e-5));
}

namespace {

BodyStates one_at_5_m_s() {
  BodyStates bodies;
  bodies.count = 1;
  bodies.V_WB[0].v = {3, 0, 4};
  return bodies;
}

}  // namespace

BOOST_AUTO_TEST_CASE(velocities_are_scaled_to_rest_at_most_and_the_rest_stays_owed) {
  PassivityObserver observer;
  BodyStates bodies = one_at_5_m_s();
  observer.observe(2, 0.5, 1e9);
  BOOST_TEST(observer.generated() == 1.5);
  BOOST_TEST(observer.dissipate(0, 1, bodies) == 1.0);
  BOOST_TEST(norm(bodies.V_WB[0].v) == 0.0);
  bodies.V_WB[0].v = {3, 0, 4};
  BOOST_TEST(observer.dissipate(0, 2, bodies) == 0.5);
  BOOST_TEST(norm(bodies.V_WB[0].v) == 5 * std::sqrt(0.75), tt::tolerance(1e-12));
  BOOST_TEST(observer.dissipate(0, 2, bodies) == 0.0);
}

BOOST_AUTO_TEST_CASE(what_the_handle_took_out_is_not_owed) {
  PassivityObserver observer;
  BodyStates bodies = one_at_5_m_s();
  observer.observe(1, 0, 1);             // a plane that jumps
  observer.observe(-0.75, -0.75, 0.25);  // the handle is pushed back
  BOOST_TEST(observer.dissipate(0, 10, bodies) == 0.25);
  observer.observe(5, 5, 5.25);
  BOOST_TEST(observer.dissipate(0, 10, bodies) == 0.0);
}

BOOST_AUTO_TEST_CASE(small_debts_and_slow_motion_are_left_alone) {
  PassivityObserver observer;
  BodyStates bodies = one_at_5_m_s();
  observer.observe(1, 0, 1e9);
  BOOST_TEST(observer.dissipate(1, 10, bodies) == 0.0);
  BOOST_TEST(observer.dissipate(0.5, 0.5, bodies) == 0.0);
  BOOST_TEST((bodies.V_WB[0].v == Vec3{3, 0, 4}));
  BOOST_TEST(observer.dissipate(0.25, 0.5, bodies) == 0.25);
  BOOST_TEST(norm(bodies.V_WB[0].v) == 5 * std::sqrt(0.5), tt::tolerance(1e-12));
  BOOST_TEST(observer.dissipate(0.25, 10, bodies) == 0.5);
  BOOST_TEST(observer.taken() == 0.75);
}

BOOST_AUTO_TEST_SUITE_END()
