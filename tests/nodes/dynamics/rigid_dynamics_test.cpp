// The node moves the tool through every device sample, up to the time it is asked for.
#include <algorithm>
#include <boost/test/unit_test.hpp>

#include <limits>

#include "nodes/dynamics/rigid.hpp"
#include "tests/nodes/defaults.hpp"

using namespace tactor;

namespace {

Scene scene_of(Motion motion) {
  Scene scene;
  Body tool;
  tool.name = "tool";
  tool.shape = SphereShape{0.01};
  tool.motion = motion;
  tool.X_WB.p = {0, 0, 0.5};
  scene.bodies.push_back(tool);
  return scene;
}

struct Rig {
  explicit Rig(RigidDynamics::Params params = test::default_params<RigidDynamics>(), bool with_contacts = true,
               Motion motion = Motion::translation)
      : scene(scene_of(motion)), node(params, test::context_for(scene)) {
    if (with_contacts) node.contacts.configure({});
    node.device.configure({QueuePolicy::drop_oldest, 4096});
    node.law.configure({});
    node.law.push({}, &law);
  }
  void device(std::int64_t ms, const Vec3& p, const Quat& R = {}) {
    DeviceState d;
    d.X_WD = {p, R};
    node.device.push({Time{ms * 1'000'000}, Time{ms * 1'000'000}, 0}, &d);
  }
  void contacts(std::int64_t ms, const ContactSet& set = {}) {
    node.contacts.push({Time{ms * 1'000'000}, Time{ms * 1'000'000}, 0}, &set);
  }
  std::size_t step(std::int64_t ms) {
    node.state.clear_pending();
    StepContext context(Time{ms * 1'000'000});
    node.step(context);
    return node.state.pending();
  }
  [[nodiscard]] const PhysicsState& state() const { return test::sent(node.state); }
  [[nodiscard]] std::int64_t valid_ms() const { return node.state.pending_valid(0).ns / 1'000'000; }

  Scene scene;
  CouplingLaw law{.k_t = 500, .b_t = 14, .k_r = 1, .b_r = 0.01, .force_max = 8, .torque_max = 0.3};
  RigidDynamics node;
};

}  // namespace

BOOST_AUTO_TEST_CASE(nothing_is_sent_before_the_first_sample) {
  Rig rig;
  rig.contacts(1);
  BOOST_TEST(rig.step(2) == 0U);
}

BOOST_AUTO_TEST_CASE(the_tool_starts_at_the_handle_or_where_the_scene_puts_it) {
  RigidDynamics::Params p = test::default_params<RigidDynamics>();
  for (const bool at_device : {true, false}) {
    p.start_at_device = at_device;
    Rig rig(p);
    rig.device(1, {0.1, 0.2, 0.3});
    rig.contacts(1);
    BOOST_REQUIRE(rig.step(2) == 1U);
    BOOST_TEST(norm(rig.state().X_WT.p - (at_device ? Vec3{0.1, 0.2, 0.3} : Vec3{0, 0, 0.5})) == 0.0);
    BOOST_TEST(rig.valid_ms() == 1);
  }
}

BOOST_AUTO_TEST_CASE(it_stops_at_the_time_of_the_contact_query_and_keeps_later_samples) {
  Rig rig;
  for (int ms = 1; ms <= 12; ++ms) rig.device(ms, {0.001 * ms, 0, 0});
  rig.contacts(8);
  BOOST_REQUIRE(rig.step(12) == 1U);
  BOOST_TEST(rig.valid_ms() == 8);
  BOOST_TEST(rig.state().X_WD.p.x == 0.008);
  rig.contacts(12);
  BOOST_REQUIRE(rig.step(20) == 1U);
  BOOST_TEST(rig.valid_ms() == 12);
  BOOST_TEST(rig.state().X_WD.p.x == 0.012);
}

BOOST_AUTO_TEST_CASE(it_goes_on_to_now_where_asked_to_or_without_contacts) {
  RigidDynamics::Params p = test::default_params<RigidDynamics>();
  p.advance_to = RigidDynamics::AdvanceTo::now;
  for (const bool with_contacts : {true, false}) {
    Rig rig(p, with_contacts);
    if (!with_contacts) p.advance_to = RigidDynamics::AdvanceTo::contacts;
    for (int ms = 1; ms <= 12; ++ms) rig.device(ms, {});
    if (with_contacts) rig.contacts(8);
    BOOST_REQUIRE(rig.step(12) == 1U);
    BOOST_TEST(rig.valid_ms() == 12);
  }
}

BOOST_AUTO_TEST_CASE(one_late_step_equals_many_prompt_ones) {
  for (const Motion motion : {Motion::translation, Motion::rigid}) {
    const RigidDynamics::Params p = test::default_params<RigidDynamics>();
    Rig late(p, false, motion), prompt(p, false, motion);
    for (int ms = 0; ms <= 40; ++ms) {
      const Vec3 x{0.01 * std::sin(0.1 * ms), 0, 0.002 * ms};
      const Quat R = from_rotation_vector({0.01 * ms, 0, 0.2});
      late.device(ms, x, R);
      prompt.device(ms, x, R);
      BOOST_REQUIRE(prompt.step(ms) == 1U);
    }
    BOOST_REQUIRE(late.step(40) == 1U);
    BOOST_TEST(norm(late.state().X_WT.p - prompt.state().X_WT.p) == 0.0);
    BOOST_TEST((late.state().X_WT.R == prompt.state().X_WT.R));
    BOOST_TEST(norm(late.state().V_WT.v) > 0.1);
  }
}

BOOST_AUTO_TEST_CASE(orientation_stays_in_a_scene_that_only_translates) {
  Rig rig(test::default_params<RigidDynamics>(), false);
  for (int ms = 0; ms < 20; ++ms) rig.device(ms, {}, from_rotation_vector({0, 0, 0.1 * ms}));
  BOOST_REQUIRE(rig.step(20) == 1U);
  BOOST_TEST((rig.state().X_WT.R == Quat{}));
  BOOST_TEST(norm(rig.state().V_WT.w) == 0.0);
}

BOOST_AUTO_TEST_CASE(the_tool_feels_the_spring_beyond_the_devices_limit) {
  RigidDynamics::Params p = test::default_params<RigidDynamics>();
  p.start_at_device = false;
  Rig rig(p, false);
  rig.device(0, {0, 0, 0.5});
  for (int ms = 1; ms < 500; ++ms) rig.device(ms, {0, 0, 1.5});
  BOOST_REQUIRE(rig.step(500) == 1U);
  BOOST_TEST(rig.state().X_WT.p.z == 1.5 - 0.1 * 9.81 / 500, boost::test_tools::tolerance(1e-9));
}

BOOST_AUTO_TEST_CASE(a_sample_that_is_not_finite_is_left_out_and_counted) {
  Rig rig(test::default_params<RigidDynamics>(), false);
  rig.device(0, {});
  rig.device(1, {std::numeric_limits<double>::quiet_NaN(), 0, 0});
  rig.device(2, {0.001, 0, 0});
  BOOST_REQUIRE(rig.step(3) == 1U);
  BOOST_TEST(rig.valid_ms() == 2);
  BOOST_TEST(is_finite(rig.state().X_WT.p));
  Report report;
  rig.node.report(report);
  BOOST_TEST(report.figures()[0].first == "dynamics_fallbacks");
  BOOST_TEST(report.figures()[0].second == 0.0);
  const auto rejected = std::find_if(report.figures().begin(), report.figures().end(),
                                     [](const auto& f) { return f.first == "dynamics_rejected_samples"; });
  BOOST_REQUIRE((rejected != report.figures().end()));
  BOOST_TEST(rejected->second == 1.0);
}

BOOST_AUTO_TEST_CASE(contacts_hold_the_tool_up) {
  RigidDynamics::Params p = test::default_params<RigidDynamics>();
  p.start_at_device = false;
  Rig rig(p);
  ContactSet set;
  set.bodies.X_WB[0].p = {0, 0, 0.5};
  set.count = 1;
  set.contact[0] = {.p_TC = {0, 0, -0.01},
                    .p_WC = {0, 0, 0.489},
                    .n_W = {0, 0, 1},
                    .distance = 0.001,
                    .weight = 1,
                    .stiffness = 2000,
                    .damping = 2,
                    .friction = 0.3};
  rig.device(0, {0, 0, 0.5});
  for (int ms = 1; ms < 500; ++ms) rig.device(ms, {0, 0, 0.49});
  rig.contacts(499, set);
  BOOST_REQUIRE(rig.step(500) == 1U);
  // Balance: k_t (0.49 - z) - m g + k_c (0.499 - z) = 0.
  const double z = (500 * 0.49 - 0.1 * 9.81 + 2000 * 0.499) / 2500;
  BOOST_TEST(rig.state().X_WT.p.z == z, boost::test_tools::tolerance(1e-9));
  BOOST_TEST(rig.state().contact_T_W.force.z == 2000 * (0.499 - z), boost::test_tools::tolerance(1e-6));
  BOOST_TEST(rig.state().contacts == 1);
}
