// The couplings' signs, limits, passivity and laws.
#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <cmath>

#include "nodes/coupling/adaptive.hpp"
#include "nodes/coupling/dynamic.hpp"
#include "nodes/coupling/static.hpp"
#include "nodes/physics/mechanics/coupling_wrench.hpp"
#include "tests/support/nodes.hpp"

BOOST_AUTO_TEST_SUITE(coupling_test)

using namespace tactor;

namespace {

const CouplingParameters firm{.k_t = 500, .b_t = 10, .k_r = 2, .b_r = 0.01, .force_max = 1e9, .torque_max = 1e9};

Scene scene_of(double mass, Motion motion = Motion::rigid, double radius = 0.02) {
  Scene scene;
  Body tool;
  tool.name = "tool";
  tool.shape = SphereShape{radius};
  tool.mass = mass;
  tool.motion = motion;
  scene.bodies.push_back(tool);
  return scene;
}

template <class N>
CouplingParameters law_of(const Scene& scene, const typename N::Params& params) {
  N node(params, test::context_for(scene));
  StepContext context(Time{0});
  node.start(context);
  return test::sent(node.parameters);
}

PhysicsState stretched() {
  PhysicsState s;
  s.X_WD = {{0.01, 0.02, -0.01}, from_rotation_vector({0.1, -0.2, 0.3})};
  s.X_WT = {{0.012, 0.01, 0.0}, from_rotation_vector({-0.2, 0.1, 0.1})};
  s.V_WD = {{0.1, 0, 0}, {0, 0.5, 0}};
  s.V_WT = {{0, 0.2, 0}, {0.3, 0, 0}};
  return s;
}

}  // namespace

BOOST_AUTO_TEST_CASE(the_device_is_pulled_towards_the_tool) {
  PhysicsState s;
  s.X_WD.p = {0.01, 0, 0};
  s.X_WD.R = from_rotation_vector({0, 0, 0.1});
  Wrench f = coupling_wrench(firm, s, true);
  BOOST_TEST(f.force.x == -5.0, boost::test_tools::tolerance(1e-12));
  BOOST_TEST(f.torque.z == -0.2, boost::test_tools::tolerance(1e-12));
  s = {};
  s.V_WD = {{0, 1, 0}, {0, 1, 0}};
  f = coupling_wrench(firm, s, true);
  BOOST_TEST(f.force.y == -10.0);
  BOOST_TEST(f.torque.y == -0.01);
}

BOOST_AUTO_TEST_CASE(saturation_keeps_the_direction) {
  CouplingParameters limited = firm;
  limited.force_max = 3;
  limited.torque_max = 0.05;
  const Wrench full = coupling_wrench(firm, stretched(), true), cut = coupling_wrench(limited, stretched(), true);
  BOOST_TEST(norm(full.force) > 3.0);
  BOOST_TEST(norm(cut.force) == 3.0, boost::test_tools::tolerance(1e-12));
  BOOST_TEST(norm(cut.torque) == 0.05, boost::test_tools::tolerance(1e-12));
  BOOST_TEST(norm(cross(full.force, cut.force)) < 1e-12);
  BOOST_TEST(dot(full.force, cut.force) > 0);
  BOOST_TEST(dot(full.torque, cut.torque) > 0);
}

BOOST_AUTO_TEST_CASE(a_quaternion_and_its_negative_give_the_same_torque) {
  PhysicsState s = stretched();
  const Wrench a = coupling_wrench(firm, s, true);
  s.X_WD.R = {-s.X_WD.R.w, -s.X_WD.R.x, -s.X_WD.R.y, -s.X_WD.R.z};
  BOOST_TEST(norm(coupling_wrench(firm, s, true).torque - a.torque) < 1e-12);
}

BOOST_AUTO_TEST_CASE(there_is_no_torque_in_a_scene_that_only_translates) {
  BOOST_TEST(norm(coupling_wrench(firm, stretched(), false).torque) == 0.0);
  const Scene scene = scene_of(0.1, Motion::translation);
  const CouplingParameters coupling = law_of<DynamicCoupling>(scene, test::default_params<DynamicCoupling>());
  BOOST_TEST(coupling.k_r == 0.0);
  BOOST_TEST(coupling.b_r == 0.0);
}

BOOST_AUTO_TEST_CASE(spring_and_damper_take_up_at_least_the_energy_they_store) {
  // The handle and the tool move on smooth closed paths; work is summed by the trapezium rule.
  double taken = 0;
  Wrench last;
  PhysicsState before;
  const int steps = 20000;
  double least_margin = 1;
  for (int i = 0; i <= steps; ++i) {
    const double t = 2.0 * i / steps, w = 7;
    PhysicsState s;
    s.X_WD.p = {0.01 * std::sin(w * t), 0.02 * std::sin(2 * w * t), 0};
    s.V_WD.v = {0.01 * w * std::cos(w * t), 0.04 * w * std::cos(2 * w * t), 0};
    s.X_WT.p = {0, 0.015 * std::sin(3 * w * t), 0.01 * std::sin(w * t)};
    s.V_WT.v = {0, 0.045 * w * std::cos(3 * w * t), 0.01 * w * std::cos(w * t)};
    const double angle = 0.8 * std::sin(w * t);
    s.X_WD.R = from_rotation_vector({0, 0, angle});
    s.V_WD.w = {0, 0, 0.8 * w * std::cos(w * t)};
    const Wrench f = coupling_wrench(firm, s, true);
    if (i > 0) {
      const Vec3 slide = (s.X_WD.p - s.X_WT.p) - (before.X_WD.p - before.X_WT.p);
      const Vec3 turn = to_rotation_vector(s.X_WD.R * inverse(before.X_WD.R));
      taken -= 0.5 * dot(f.force + last.force, slide) + 0.5 * dot(f.torque + last.torque, turn);
    }
    const Vec3 stretch = s.X_WD.p - s.X_WT.p;
    const double stored = 0.5 * firm.k_t * dot(stretch, stretch) + 0.5 * firm.k_r * angle * angle;
    least_margin = std::min(least_margin, taken - stored);
    last = f;
    before = s;
  }
  BOOST_TEST(least_margin > -1e-6);
  BOOST_TEST(taken > 0.01);
}

BOOST_AUTO_TEST_CASE(the_damper_is_critical_for_the_tools_mass_and_inertia) {
  const Scene scene = scene_of(0.2);
  const CouplingParameters coupling = law_of<DynamicCoupling>(scene, test::default_params<DynamicCoupling>());
  BOOST_TEST(coupling.massless == 0);
  BOOST_TEST(coupling.k_t == 500.0);
  BOOST_TEST(coupling.b_t == 2 * std::sqrt(500 * 0.2), boost::test_tools::tolerance(1e-12));
  BOOST_TEST(coupling.b_r == 2 * std::sqrt(coupling.k_r * 0.4 * 0.2 * 4e-4), boost::test_tools::tolerance(1e-12));
}

BOOST_AUTO_TEST_CASE(the_static_coupling_has_no_damper_and_no_mass) {
  const CouplingParameters coupling = law_of<StaticCoupling>(scene_of(0.2), test::default_params<StaticCoupling>());
  BOOST_TEST(coupling.massless == 1);
  BOOST_TEST(coupling.b_t == 0.0);
  BOOST_TEST(coupling.b_r == 0.0);
}

BOOST_AUTO_TEST_CASE(the_adaptive_sag_grows_less_than_the_mass) {
  AdaptiveCoupling::Params p = test::default_params<AdaptiveCoupling>();
  p.k_min = 1;
  p.k_device = 1e6;
  const auto sag = [&](double mass) { return mass * 9.81 / law_of<AdaptiveCoupling>(scene_of(mass), p).k_t; };
  BOOST_TEST(sag(0.1) == 0.1 * 9.81 / 500, boost::test_tools::tolerance(1e-12));
  for (const double mass : {0.05, 0.1, 0.2, 0.8}) {
    BOOST_TEST(sag(2 * mass) > sag(mass));
    BOOST_TEST(sag(2 * mass) / sag(mass) == std::sqrt(2.0), boost::test_tools::tolerance(1e-12));
  }
  p.a = 1;
  BOOST_TEST(sag(0.4) == sag(0.1), boost::test_tools::tolerance(1e-12));
  p.a = 0;
  BOOST_TEST(sag(0.4) == 4 * sag(0.1), boost::test_tools::tolerance(1e-12));
}

BOOST_AUTO_TEST_CASE(the_adaptive_stiffness_stays_within_its_bounds) {
  AdaptiveCoupling::Params p = test::default_params<AdaptiveCoupling>();
  BOOST_TEST(law_of<AdaptiveCoupling>(scene_of(100), p).k_t == p.k_device);
  BOOST_TEST(law_of<AdaptiveCoupling>(scene_of(1e-6), p).k_t == p.k_min);
  BOOST_TEST(law_of<AdaptiveCoupling>(scene_of(100), p).k_r == p.k_r_device);
  p.k_min = 2000;
  BOOST_CHECK_THROW(law_of<AdaptiveCoupling>(scene_of(1), p), InputError);
}

BOOST_AUTO_TEST_CASE(a_limit_that_takes_the_place_of_the_asked_stiffness_is_noted) {
  const auto notes_of = [](double k_0, double mass) {
    AdaptiveCoupling::Params p = test::default_params<AdaptiveCoupling>();
    p.k_0 = k_0;
    p.k_r_min = 1e-9, p.k_r_device = 1e9;
    const Scene scene = scene_of(mass);
    std::vector<std::string> notes;
    NodeContext context = test::context_for(scene);
    context.notes = &notes;
    const AdaptiveCoupling node(p, context);
    return notes;
  };
  // k_0 (m / 0.1 kg)^0.5 = 1000 N/m at m = 0.4 kg: at the limit, and just above it.
  BOOST_TEST(notes_of(500, 0.39).empty());
  BOOST_REQUIRE(notes_of(500, 0.41).size() == 1U);
  BOOST_TEST(notes_of(500, 0.41)[0].find("k_0 asks for 1012") != std::string::npos);
  BOOST_TEST(notes_of(500, 0.41)[0].find("k_device holds it at 1000") != std::string::npos);
  BOOST_REQUIRE(notes_of(50, 0.1).size() == 1U);
  BOOST_TEST(notes_of(50, 0.1)[0].find("k_min holds it at 100") != std::string::npos);
}

BOOST_AUTO_TEST_CASE(a_force_is_stamped_as_the_state_it_belongs_to) {
  const Scene scene = scene_of(0.1);
  DynamicCoupling node(test::default_params<DynamicCoupling>(), test::context_for(scene));
  node.state.configure({});
  StepContext context(Time{9'000'000});
  node.step(context);
  BOOST_TEST(node.force.pending() == 0U);
  const PhysicsState s = stretched();
  node.state.push({Time{5'000'000}, Time{8'000'000}, 0}, &s);
  node.step(context);
  BOOST_REQUIRE(node.force.pending() == 1U);
  BOOST_TEST(node.force.pending_valid(0).ns == 5'000'000);
  BOOST_TEST(norm(test::sent(node.force).force) <= 8.0 + 1e-12);
}

BOOST_AUTO_TEST_CASE(parameters_that_are_set_are_reached_in_a_tenth_of_a_second_in_a_straight_line) {
  const Scene scene = scene_of(0.2);
  auto params = test::default_params<DynamicCoupling>();
  params.k_t = 400;
  DynamicCoupling node(params, test::context_for(scene));
  node.state.configure({QueuePolicy::latest, 1});
  StepContext begin(Time{0});
  node.start(begin);
  node.parameters.clear_pending();
  params.k_t = 1200;
  params.force_max = 4;
  node.tune(params);
  PhysicsState state;
  state.X_WD.p = {-0.004, 0, 0};  // less than force_max
  const double b_from = damping_of(400, 0.2, params.zeta), b_to = damping_of(1200, 0.2, params.zeta);
  for (int i = 0; i <= 12; ++i) {
    const Time now{1'000'000'000 + 10'000'000 * i};
    const Stamp stamp{now, now, static_cast<std::uint64_t>(i)};
    node.state.push(stamp, &state);
    StepContext context(now);
    node.step(context);
    const double share = std::min(0.1 * i, 1.0);
    const double k = 400 + share * 800;
    BOOST_TEST(test::sent(node.force).force.x == std::min(0.004 * k, 8 - 4 * share),
               boost::test_tools::tolerance(1e-12));
    // Told with every change, to the exact end, and not after.
    BOOST_REQUIRE(node.parameters.pending() == (i <= 10 ? 1U : 0U));
    if (i <= 10) {
      BOOST_TEST(test::sent(node.parameters).k_t == k, boost::test_tools::tolerance(1e-12));
      BOOST_TEST(test::sent(node.parameters).b_t == b_from + share * (b_to - b_from),
                 boost::test_tools::tolerance(1e-12));
    }
    if (i == 10) BOOST_TEST(test::sent(node.parameters).k_t == 1200);
    node.force.clear_pending();
    node.parameters.clear_pending();
  }
}

BOOST_AUTO_TEST_CASE(every_coupling_ends_with_the_parameters_it_would_have_been_made_with) {
  const Scene scene = scene_of(0.15);
  const auto check = [&scene]<class N>(N*, auto&& change) {
    auto params = test::default_params<N>();
    N node(params, test::context_for(scene));
    change(params);
    const CouplingParameters expected = law_of<N>(scene, params);
    node.state.configure({QueuePolicy::latest, 1});
    node.tune(params);
    const PhysicsState state = stretched();
    for (int i = 0; i < 2; ++i) {
      const Time now{200'000'000 * i};
      const Stamp stamp{now, now, static_cast<std::uint64_t>(i)};
      node.state.push(stamp, &state);
      StepContext context(now);
      node.parameters.clear_pending();
      node.step(context);
    }
    const CouplingParameters& found = test::sent(node.parameters);
    BOOST_TEST(found.k_t == expected.k_t);
    BOOST_TEST(found.b_t == expected.b_t);
    BOOST_TEST(found.k_r == expected.k_r);
    BOOST_TEST(found.b_r == expected.b_r);
    BOOST_TEST(found.force_max == expected.force_max);
    BOOST_TEST(found.massless == expected.massless);
  };
  check(static_cast<StaticCoupling*>(nullptr), [](auto& p) { p.k_t = 777, p.force_max = 3; });
  check(static_cast<DynamicCoupling*>(nullptr), [](auto& p) { p.k_t = 777, p.k_r = 2, p.zeta = 0.5; });
  check(static_cast<AdaptiveCoupling*>(nullptr), [](auto& p) { p.k_0 = 777, p.a = 0.3, p.force_max = 3; });
}

BOOST_AUTO_TEST_SUITE_END()
