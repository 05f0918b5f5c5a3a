// The node moves the tool through every device sample, up to the time it is asked for.
#include <algorithm>
#include <boost/test/unit_test.hpp>

#include <limits>
#include <memory>

#include "nodes/dynamics/quasistatic.hpp"
#include "nodes/dynamics/rigid.hpp"
#include "nodes/dynamics/translation.hpp"
#include "nodes/physics/mesh/body_mesh.hpp"
#include "tests/nodes/dynamics/node_rig.hpp"
#include "tests/nodes/physics/mechanics/one_body.hpp"

BOOST_AUTO_TEST_SUITE(dynamics_nodes_test)

using namespace tactor;
using namespace tactor::test;
namespace tt = boost::test_tools;

namespace {

Scene scene_of(Motion motion) {
  Scene scene = ball_scene(motion);
  scene.gravity_W = {0, 0, -9.81};
  scene.bodies[0].X_WB.p = {0, 0, 0.5};
  return scene;
}

struct Rig : NodeRig<RigidDynamics> {
  explicit Rig(const RigidDynamics::Params& params = default_params<RigidDynamics>(), bool with_contacts = true,
               Motion motion = Motion::translation)
      : NodeRig(params, scene_of(motion), with_contacts) {}
};

}  // namespace

BOOST_AUTO_TEST_CASE(nothing_is_sent_before_the_first_sample) {
  Rig rig;
  rig.contacts(1);
  BOOST_TEST(rig.step(2) == 0U);
}

BOOST_AUTO_TEST_CASE(the_tool_starts_at_the_handle_or_where_the_scene_puts_it) {
  RigidDynamics::Params p = default_params<RigidDynamics>();
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
  RigidDynamics::Params p = default_params<RigidDynamics>();
  p.advance_to = DynamicsParams::AdvanceTo::now;
  for (const bool with_contacts : {true, false}) {
    Rig rig(p, with_contacts);
    if (!with_contacts) p.advance_to = DynamicsParams::AdvanceTo::contacts;
    for (int ms = 1; ms <= 12; ++ms) rig.device(ms, {});
    if (with_contacts) rig.contacts(8);
    BOOST_REQUIRE(rig.step(12) == 1U);
    BOOST_TEST(rig.valid_ms() == 12);
  }
}

BOOST_AUTO_TEST_CASE(one_late_step_equals_many_prompt_ones) {
  for (const Motion motion : {Motion::translation, Motion::rigid}) {
    RigidDynamics::Params p = default_params<RigidDynamics>();
    // The handle's velocity is not that of its way here, which makes energy; energies are rounded, bare steps are not.
    p.dissipate_above = 1e6;
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
  Rig rig(default_params<RigidDynamics>(), false);
  for (int ms = 0; ms < 20; ++ms) rig.device(ms, {}, from_rotation_vector({0, 0, 0.1 * ms}));
  BOOST_REQUIRE(rig.step(20) == 1U);
  BOOST_TEST((rig.state().X_WT.R == Quat{}));
  BOOST_TEST(norm(rig.state().V_WT.w) == 0.0);
}

BOOST_AUTO_TEST_CASE(the_tool_feels_the_spring_beyond_the_devices_limit) {
  RigidDynamics::Params p = default_params<RigidDynamics>();
  p.start_at_device = false;
  Rig rig(p, false);
  rig.device(0, {0, 0, 0.5});
  for (int ms = 1; ms < 500; ++ms) rig.device(ms, {0, 0, 1.5});
  BOOST_REQUIRE(rig.step(500) == 1U);
  BOOST_TEST(rig.state().X_WT.p.z == 1.5 - 0.1 * 9.81 / 500, boost::test_tools::tolerance(1e-9));
}

BOOST_AUTO_TEST_CASE(a_sample_that_is_not_finite_is_left_out_and_counted) {
  Rig rig(default_params<RigidDynamics>(), false);
  rig.device(0, {});
  rig.device(1, {std::numeric_limits<double>::quiet_NaN(), 0, 0});
  rig.device(2, {0.001, 0, 0});
  BOOST_REQUIRE(rig.step(3) == 1U);
  BOOST_TEST(rig.valid_ms() == 2);
  BOOST_TEST(is_finite(rig.state().X_WT.p));
  BOOST_TEST(rig.metrics()["dynamics_rejected_samples"] == 1.0);
  BOOST_TEST(rig.metrics()["dynamics_stopped_steps"] == 0.0);
}

BOOST_AUTO_TEST_CASE(contacts_hold_the_tool_up) {
  RigidDynamics::Params p = default_params<RigidDynamics>();
  p.start_at_device = false;
  Rig rig(p);
  ContactSet set;
  set.bodies.count = 1;
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

BOOST_AUTO_TEST_CASE(all_moving_bodies_are_sent_with_the_tool_first) {
  Scene scene = ball_scene(Motion::rigid);
  Body other = ball("other", Motion::rigid);
  other.X_WB.p = {0.1, 0, 0};
  scene.bodies.insert(scene.bodies.begin(), other);
  scene.tool_name = "tool";
  NodeRig<RigidDynamics> rig(default_params<RigidDynamics>(), scene);
  // Nothing holds the tool, so that the two have the momentum of the start, none, while they push each other away.
  rig.coupling = {};
  rig.push_law();
  ContactSet set;
  set.bodies.count = 2;
  set.bodies.X_WB[1].p = {0.1, 0, 0};
  set.count = 1;
  set.contact[0] = floor_at({}, -0.001);
  set.contact[0].n_W = {-1, 0, 0};
  set.pair[0] = {0, 1};
  for (int ms = 0; ms <= 30; ++ms) rig.device(ms, {});
  rig.contacts(1);
  BOOST_REQUIRE(rig.step(1) == 1U);
  rig.contacts(30, set);
  BOOST_REQUIRE(rig.step(30) == 1U);
  const BodyStates& bodies = sent(rig.node.bodies);
  BOOST_TEST(bodies.count == 2);
  BOOST_TEST((bodies.X_WB[0] == rig.state().X_WT));
  BOOST_TEST(bodies.V_WB[1].v.x > 0.01);
  BOOST_TEST(norm(0.1 * bodies.V_WB[0].v + 0.1 * bodies.V_WB[1].v) < 1e-15);
  BOOST_TEST(norm(0.1 * (bodies.X_WB[0].p + bodies.X_WB[1].p - Vec3{0.1, 0, 0})) < 1e-15);
}

BOOST_AUTO_TEST_CASE(translation_refuses_a_body_that_may_rotate) {
  Scene scene = ball_scene(Motion::translation);
  scene.bodies.push_back(ball("lid", Motion::rigid));
  BOOST_CHECK_EXCEPTION(TranslationDynamics(default_params<TranslationDynamics>(), context_for(scene)), InputError,
                        [](const InputError& e) {
                          return std::string(e.what()).find("dynamics.translation: body 'lid' has motion: rigid") == 0;
                        });
}

BOOST_AUTO_TEST_CASE(translation_moves_as_rigid_does_where_nothing_turns) {
  NodeRig<TranslationDynamics> plain(default_params<TranslationDynamics>(), scene_of(Motion::translation));
  NodeRig<RigidDynamics> full(default_params<RigidDynamics>(), scene_of(Motion::rigid));
  for (int ms = 0; ms <= 40; ++ms) {
    const Vec3 p{0.01 * std::sin(0.1 * ms), 0, 0.002 * ms};
    plain.device(ms, p);
    full.device(ms, p);
  }
  plain.contacts(40);
  full.contacts(40);
  BOOST_REQUIRE(plain.step(40) == 1U);
  BOOST_REQUIRE(full.step(40) == 1U);
  BOOST_TEST(norm(plain.state().X_WT.p - full.state().X_WT.p) < 1e-14);
}

BOOST_AUTO_TEST_CASE(a_massless_law_stops_a_node_whose_bodies_have_mass) {
  Rig rig;
  rig.coupling.massless = 1;
  rig.push_law();
  rig.device(1, {});
  rig.contacts(1);
  BOOST_CHECK_EXCEPTION(rig.step(1), RunError, [](const RunError& e) {
    return std::string(e.what()).find("dynamics.rigid") == 0 &&
           std::string(e.what()).find("use dynamics.quasistatic") != std::string::npos;
  });
}

BOOST_AUTO_TEST_CASE(a_damper_alone_stops_a_node_whose_tool_does_not_start_at_the_handle) {
  RigidDynamics::Params p = default_params<RigidDynamics>();
  for (const bool at_device : {true, false}) {
    p.start_at_device = at_device;
    Rig rig(p);
    rig.coupling.k_t = 0;
    rig.coupling.b_t = 20;
    rig.push_law();
    rig.device(1, {});
    rig.contacts(1);
    if (at_device) {
      BOOST_TEST(rig.step(1) == 1U);
    } else {
      BOOST_CHECK_EXCEPTION(rig.step(1), RunError, [](const RunError& e) {
        return std::string(e.what()).find("dynamics.rigid: start_at_device is false") == 0;
      });
    }
  }
}

BOOST_AUTO_TEST_CASE(a_quasistatic_tool_is_the_handle_where_nothing_touches) {
  NodeRig<QuasistaticDynamics> rig(default_params<QuasistaticDynamics>(), scene_of(Motion::rigid));
  for (int ms = 0; ms <= 100; ++ms) {
    const Vec3 p{0.01 * std::sin(0.3 * ms), 0.2, 0.002 * ms};
    const Quat R = from_rotation_vector({0.02 * ms, 0.01 * ms, 0});
    rig.device(ms, p, R);
    rig.contacts(ms);
    BOOST_REQUIRE(rig.step(ms) == 1U);
    BOOST_TEST(norm(rig.state().X_WT.p - p) < 1e-15);
    BOOST_TEST(norm(to_rotation_vector(rig.state().X_WT.R * inverse(R))) < 1e-14);
  }
}

BOOST_AUTO_TEST_CASE(a_quasistatic_tool_rests_where_the_springs_balance_at_once) {
  NodeRig<QuasistaticDynamics> rig(default_params<QuasistaticDynamics>(), scene_of(Motion::rigid));
  ContactSet set;
  set.bodies.count = 1;
  set.count = 1;
  set.contact[0] = floor_at({}, 0, 2000, 50, 0);
  rig.device(0, {});
  rig.contacts(0);
  BOOST_REQUIRE(rig.step(0) == 1U);
  rig.device(1, {0.003, 0, -0.01});
  rig.contacts(1, set);
  BOOST_REQUIRE(rig.step(1) == 1U);
  BOOST_TEST(rig.state().X_WT.p.z == -0.01 * 500 / 2500, tt::tolerance(1e-10));
  BOOST_TEST(rig.state().X_WT.p.x == 0.003, tt::tolerance(1e-10));
  BOOST_TEST(rig.state().contact_T_W.force.z == 0.01 * 500 * 2000 / 2500, tt::tolerance(1e-10));
}

BOOST_AUTO_TEST_CASE(quasistatic_dynamics_refuses_a_second_body) {
  Scene scene = ball_scene(Motion::rigid);
  scene.bodies.push_back(ball("lid", Motion::rigid));
  BOOST_CHECK_EXCEPTION(
      QuasistaticDynamics(default_params<QuasistaticDynamics>(), context_for(scene)), InputError,
      [](const InputError& e) { return std::string(e.what()).find("body 'lid' moves too") != std::string::npos; });
}

namespace {

/// A handle that has jumped by 10 mm pulls a critically damped tool for 1 ms times `samples`.
template <class Tune>
std::unique_ptr<NodeRig<TranslationDynamics>> pulled(int samples, Tune tune) {
  TranslationDynamics::Params p = default_params<TranslationDynamics>();
  p.start_at_device = false;
  tune(p);
  auto rig = std::make_unique<NodeRig<TranslationDynamics>>(p, ball_scene(Motion::translation), false);
  rig->coupling.b_t = 2 * std::sqrt(500 * 0.1);
  rig->push_law();
  for (int ms = 0; ms <= samples; ++ms) rig->device(ms, {0.01, 0, 0});
  BOOST_REQUIRE(rig->step(samples) == 1U);
  return rig;
}

/// The closed form: x = d (1 - (1 + w t) exp(-w t)).
double critically_damped(double t) {
  const double w = std::sqrt(500 / 0.1);
  return 0.01 * (1 - (1 + w * t) * std::exp(-w * t));
}

}  // namespace

BOOST_AUTO_TEST_CASE(the_error_estimate_is_the_error_of_a_step) {
  for (const Integrator integrator : {Integrator::implicit_euler, Integrator::midpoint}) {
    for (const double substep : {1e-3, 1e-4}) {
      const auto rig = pulled(1, [&](auto& p) {
        p.error_estimate = true;
        p.substep = substep;
        p.integrator = integrator;
      });
      const double error = std::abs(rig->state().X_WT.p.x - critically_damped(1e-3));
      // Errors of sub-steps grow and fade on the way to the end of the sample; the sum of the estimates leaves that
      // out.
      BOOST_TEST(rig->metrics()["dynamics_position_error_max_m"] == error, tt::tolerance(0.25));
      BOOST_TEST(rig->metrics()["dynamics_position_error_mean_m"] == rig->metrics()["dynamics_position_error_max_m"]);
    }
  }
}

BOOST_AUTO_TEST_CASE(the_error_estimate_changes_no_result) {
  const auto with = pulled(50, [](auto& p) { p.error_estimate = true; });
  const auto without = pulled(50, [](auto&) {});
  BOOST_TEST((with->state().X_WT == without->state().X_WT));
  BOOST_TEST(without->metrics().count("dynamics_position_error_max_m") == 0U);
}

BOOST_AUTO_TEST_CASE(by_midpoint_the_error_is_a_twentieth_and_a_tolerance_takes_fewer_sub_steps) {
  double errors[2], steps[2];
  for (const bool midpoint : {false, true}) {
    const auto tune = [&](double tolerance) {
      return [=](auto& p) {
        p.integrator = midpoint ? Integrator::midpoint : Integrator::implicit_euler;
        p.substep_tolerance = tolerance;
        p.min_substep = 1e-6;
      };
    };
    errors[midpoint] = std::abs(pulled(20, tune(0))->state().X_WT.p.x - critically_damped(0.02));
    const auto rig = pulled(20, tune(1e-7));
    steps[midpoint] = rig->metrics()["dynamics_steps"];
    BOOST_TEST(std::abs(rig->state().X_WT.p.x - critically_damped(0.02)) < steps[midpoint] * 1e-7);
  }
  BOOST_TEST(errors[1] < 0.05 * errors[0]);
  BOOST_TEST(steps[1] < 0.5 * steps[0]);
}

BOOST_AUTO_TEST_CASE(a_tolerance_shortens_the_sub_step_within_its_bounds) {
  double coarse = 0;
  for (const double tolerance : {0.0, 1e-6, 1e-7}) {
    const auto rig = pulled(20, [&](auto& p) {
      p.substep_tolerance = tolerance;
      p.min_substep = 1e-6;
    });
    const double error = std::abs(rig->state().X_WT.p.x - critically_damped(0.02));
    const double steps = rig->metrics()["dynamics_steps"];
    if (tolerance == 0) {
      BOOST_TEST(steps == 20.0);
      coarse = error;
    } else {
      BOOST_TEST(steps > 20.0);
      BOOST_TEST(error < steps * tolerance);
      BOOST_TEST(error < 0.5 * coarse);
      coarse = error;
    }
  }
  const auto bounded = pulled(20, [](auto& p) {
    p.substep_tolerance = 1e-12;
    p.min_substep = 2e-4;
  });
  BOOST_TEST(bounded->metrics()["dynamics_steps"] == 100.0);
}

BOOST_AUTO_TEST_CASE(reversed_bounds_of_the_sub_step_are_an_error) {
  RigidDynamics::Params p = default_params<RigidDynamics>();
  p.substep_tolerance = 1e-6;
  p.min_substep = 0.01;
  BOOST_CHECK_EXCEPTION(Rig{p}, InputError, [](const InputError& e) {
    return std::string(e.what()).find("dynamics.rigid: min_substep") == 0;
  });
}

BOOST_AUTO_TEST_CASE(damped_and_stopped_steps_are_counted) {
  // The counts are those of the same sub-steps taken one by one.
  ContactSet set;
  set.bodies.count = 1;
  set.bodies.X_WB[0].p = {0, 0, 0.5};
  set.count = 3;
  for (int i = 0; i < 3; ++i)
    set.contact[static_cast<std::size_t>(i)] = floor_at({0.01 * i, 0, 0}, -0.001 * i, 1e5, 1, 0.8);
  const auto handle = [](int ms) {
    return DeviceState{.X_WD = {{0.01 * ms, 0, 0.49}, from_rotation_vector({0.05 * ms, 0, 0})}, .V_WD = {}};
  };
  int seen[2] = {};
  for (const int iterations : {1, 2, 4, default_params<RigidDynamics>().iterations}) {
    RigidDynamics::Params p = default_params<RigidDynamics>();
    p.iterations = iterations;
    p.start_at_device = false;
    p.dissipate_above = 1e6;
    Rig rig(p, true, Motion::rigid);
    SystemModel model;
    model.body[0] = {.mass = 0.1, .inertia_B = body_inertia(rig.scene.bodies[0]), .rotates = true};
    model.gravity_W = rig.scene.gravity_W;
    model.iterations = iterations;
    OneBody one(model);
    one.coupling = rig.coupling;
    one.contacts.assign(set.contact.begin(), set.contact.begin() + set.count);
    one.query = one.X() = set.bodies.X_WB[0];
    one.advance(0, handle(0));
    one.X() = set.bodies.X_WB[0];
    one.V() = {};
    int damped = 0, stopped = 0;
    auto outcome = StepOutcome::converged;
    for (int ms = 0; ms <= 20; ++ms) {
      rig.device(ms, handle(ms).X_WD.p, handle(ms).X_WD.R);
      if (ms == 0) continue;
      outcome = one.advance(1e-3, handle(ms)).outcome;
      damped += outcome == StepOutcome::damped ? 1 : 0;
      stopped += outcome == StepOutcome::stopped ? 1 : 0;
    }
    rig.contacts(20, set);
    BOOST_REQUIRE(rig.step(20) == 1U);
    std::map<std::string, double> metrics = rig.metrics();
    BOOST_TEST(metrics["dynamics_steps"] == 20.0);
    BOOST_TEST(metrics["dynamics_damped_steps"] == damped);
    BOOST_TEST(metrics["dynamics_stopped_steps"] == stopped);
    BOOST_TEST(rig.state().damped == (outcome == StepOutcome::converged ? 0 : 1));
    BOOST_TEST(norm(rig.state().X_WT.p - one.X().p) < 1e-12);
    if (iterations == 1) BOOST_TEST(damped + stopped > 0);
    if (iterations > 4) BOOST_TEST(damped + stopped == 0);
    seen[0] += damped, seen[1] += stopped;
  }
  BOOST_TEST(seen[0] > 0);
  BOOST_TEST(seen[1] > 0);
}

BOOST_AUTO_TEST_CASE(a_quasistatic_tool_pressed_and_slid_for_5000_samples_needs_no_damped_step) {
  NodeRig<QuasistaticDynamics> rig(default_params<QuasistaticDynamics>(), scene_of(Motion::rigid));
  rig.coupling = {.k_t = 500, .k_r = 1, .force_max = 8, .torque_max = 0.3, .massless = 1};
  rig.push_law();
  int touching = 0;
  for (int ms = 0; ms < 5000; ++ms) {
    const double t = 1e-3 * ms;
    rig.device(ms, {0.02 * std::sin(3 * t), 0.01 * std::sin(5 * t), 0.004 - 0.01 * std::sin(t) * std::sin(t)},
               from_rotation_vector({0.2 * std::sin(2 * t), 0.1 * std::sin(7 * t), 0.3 * t}));
    if (ms % 7 != 0) continue;
    // Four feet over the plane z = 0, where the tool was last.
    ContactSet set;
    set.bodies.count = 1;
    if (ms > 0) set.bodies.X_WB[0] = rig.state().X_WT;
    for (const Vec3& foot : {Vec3{0.01, 0.01, 0}, {0.01, -0.01, 0}, {-0.01, 0.01, 0}, {-0.01, -0.01, 0}}) {
      const double height = transform(set.bodies.X_WB[0], foot).z;
      if (ms > 0) set.contact[static_cast<std::size_t>(set.count++)] = floor_at(foot, height, 1000, 2, 0.4);
    }
    rig.contacts(ms, set);
    BOOST_REQUIRE(rig.step(ms) == 1U);
    touching += rig.state().contacts > 0 ? 1 : 0;
  }
  BOOST_TEST(touching > 300);
  std::map<std::string, double> metrics = rig.metrics();
  BOOST_TEST(metrics["dynamics_steps"] >= 4990.0);
  BOOST_TEST(metrics["dynamics_damped_steps"] == 0.0);
  BOOST_TEST(metrics["dynamics_stopped_steps"] == 0.0);
}

BOOST_AUTO_TEST_CASE(what_is_expected_is_where_a_steady_handle_leads_and_moves_nothing) {
  for (const bool expects : {true, false}) {
    Rig rig, ahead;
    rig.node.expected.set_wanted(expects);
    for (Rig* r : {&rig, &ahead}) {
      // Samples up to 20 ms; contacts of 12 ms.
      for (int ms = 1; ms <= 20; ++ms) r->device(ms, {0.001 * ms * ms, 0, 0.5});
      r->contacts(12);
      BOOST_REQUIRE(r->step(12) == 1U);
    }
    const BodyStates bodies = sent(rig.node.bodies);
    BOOST_TEST((bodies.X_WB[0].p == sent(ahead.node.bodies).X_WB[0].p));
    BOOST_TEST(rig.node.expected.pending() == (expects ? 1U : 0U));
    if (!expects) continue;
    const BodyStates expected = sent(rig.node.expected);
    BOOST_TEST(rig.node.expected.pending_valid(0).ns == 20'000'000);
    // By hand: 8 implicit steps of 1 ms along the straight line from the handle of 12 ms to that of 20 ms.
    Vec3 x = bodies.X_WB[0].p, v = bodies.V_WB[0].v;
    const double m = 0.1, h = 0.001, k = rig.coupling.k_t, b = rig.coupling.b_t;
    for (int i = 1; i <= 8; ++i) {
      const Vec3 x_D{0.144 + i / 8.0 * (0.400 - 0.144), 0, 0.5};
      v = 1 / (m + h * b + h * h * k) * (m * v + h * m * Vec3{0, 0, -9.81} + h * k * (x_D - x));
      x += h * v;
    }
    BOOST_TEST(norm(expected.X_WB[0].p - x) < 1e-9);
    BOOST_TEST(norm(expected.V_WB[0].v - v) < 1e-7);
    // Going on is as if nothing had been expected.
    for (Rig* r : {&rig, &ahead}) {
      r->contacts(20);
      BOOST_REQUIRE(r->step(20) == 1U);
    }
    BOOST_TEST((sent(rig.node.bodies).X_WB[0].p == sent(ahead.node.bodies).X_WB[0].p));
  }
}

BOOST_AUTO_TEST_CASE(a_newest_sample_of_no_use_is_not_expected_from) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  for (int kind = 0; kind < 4; ++kind) {
    Rig rig;
    for (int ms = 1; ms <= 12; ++ms) rig.device(ms, {0.001 * ms, 0, 0.5});
    if (kind == 0) rig.device(20, {none, 0, 0});
    if (kind == 1) rig.device(20, {}, {0, 0, 0, 0});
    if (kind == 2) rig.device(20, {}, {1, none, 0, 0});
    if (kind == 3) rig.device(11, {7, 7, 7});  // of the past
    rig.contacts(12);
    BOOST_REQUIRE(rig.step(12) == 1U);
    BOOST_REQUIRE(rig.node.expected.pending() == 1U);
    // It tells when it is of, so that nobody takes it for newer.
    BOOST_TEST(rig.node.expected.pending_valid(0).ns == 12'000'000);
    BOOST_TEST((sent(rig.node.expected).X_WB[0].p == sent(rig.node.bodies).X_WB[0].p));
    BOOST_TEST((sent(rig.node.expected).V_WB[0].v == sent(rig.node.bodies).V_WB[0].v));
  }
}

BOOST_AUTO_TEST_SUITE_END()
