// interpolation.rollout against motions integrated apart from it, and each of its fallbacks entered, counted and left.
#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <string>

#include "framework/core/segment.hpp"
#include "framework/realtime/allocation_watch.hpp"
#include "nodes/physics/contact/local_contacts.hpp"
#include "nodes/physics/mechanics/coupling_wrench.hpp"
#include "nodes/physics/mechanics/local_model.hpp"
#include "nodes/physics/mechanics/scene_model.hpp"
#include "tests/nodes/interpolation/rollout_subject.hpp"
#include "tests/nodes/physics/mechanics/local_contacts.hpp"
#include "tests/support/dice.hpp"
#include "tests/support/heap_is_counted.hpp"

BOOST_AUTO_TEST_SUITE(rollout_test)

using namespace tactor;
using namespace tactor::test;
namespace tt = boost::test_tools;

BOOST_AUTO_TEST_CASE(on_a_wall_the_device_shows_the_force_of_its_own_time_though_results_are_late) {
  Subject subject;
  Truth truth(0), late(0);
  const LocalContacts wall = wall_around({{0.009, 0, 0}, {0.008, 0, 0}, {0.007, 0, 0}});
  double worst = 0, held_worst = 0, largest = 0, held = 0;
  for (int ms = 0; ms <= 1500; ++ms) {
    subject.sample(ms, {Handle::x(1e-3 * ms), 0, 0}, {Handle::v(1e-3 * ms), 0, 0});
    // Every 15 ms a result of 20 ms ago, brought on to 3 ms ago.
    if (ms >= 20 && ms % 15 == 5) {
      late.advance(1e-3 * (ms - 3));
      const double t = 1e-3 * (ms - 3);
      subject.model(ms - 20, ms, model_at(ms - 3, late.bodies(), {Handle::x(t), 0, 0}, wall, {Handle::v(t), 0, 0}));
      held = truth.reaction();
    }
    if (!subject.tick(ms)) continue;
    truth.advance(1e-3 * (ms + 1));
    const double shown = subject.force(ms + 1).x;
    if (ms < 100) continue;
    worst = std::max(worst, std::abs(shown - truth.reaction()));
    held_worst = std::max(held_worst, std::abs(held - truth.reaction()));
    largest = std::max(largest, std::abs(truth.reaction()));
  }
  BOOST_TEST_MESSAGE("error " << worst << " N of " << largest << " N, held " << held_worst << " N");
  BOOST_TEST(largest > 1.0);
  // What steps of 1 ms make of it; the handle is seen without encoder steps.
  BOOST_TEST(worst < 0.01 * largest);
  BOOST_TEST(worst < 0.1 * held_worst);
  BOOST_TEST(subject.metric("fallbacks") == 0.0);
  BOOST_TEST(subject.metric("rollout.rejected_models") == 0.0);
}

BOOST_AUTO_TEST_CASE(a_correction_decays_by_two_equal_poles_and_has_neither_jump_nor_kink) {
  // A tool of a billion tonnes stays where a model has it, so what is aimed at is known.
  Subject subject(1e12);
  const Vec3 first{0.004, 0, 0}, second{0.001, 0.002, 0};
  subject.sample(0, Vec3{});
  subject.model(-5, 0, model_at(0, one_body(first), {}, {}));
  BOOST_REQUIRE(subject.tick(0));
  for (int ms = 1; ms < 60; ++ms) {
    subject.sample(ms, Vec3{});
    if (ms == 20) subject.model(5, ms, model_at(ms - 1, one_body(second), {}, {}));
    BOOST_REQUIRE(subject.tick(ms));
    BOOST_TEST(subject.jump() < 1e-9);
    BOOST_TEST(subject.kink() < 1e-6);
    const double h = std::max(0.0, 1e-3 * (ms + 1 - 20));
    const double rest = ms < 20 ? 1 : (1 + h / tau) * std::exp(-h / tau);
    const Vec3 expected = spring.k_t * (rest * first + (1 - rest) * second);
    BOOST_TEST(norm(subject.force(ms + 1) - expected) < 1e-6);
  }
  BOOST_TEST(subject.metric("rollout.correction_rms_N") == spring.k_t * norm(first - second), tt::tolerance(1e-6));
}

BOOST_AUTO_TEST_CASE(without_results_the_forecast_is_shown_where_the_tool_touched_and_else_the_last_force) {
  for (const bool touching : {true, false}) {
    for (const bool forecasts : {true, false}) {
      Rollout::Params params = anchored();
      params.trust_time = Duration::from_seconds(0.1);
      Subject subject(1e12, params, forecasts);
      const LocalContacts wall = wall_around({{0.009, 0, 0}});
      const Vec3 tool{touching ? 0.009 : 0.02, 0, 0}, handle = tool - Vec3{0.002, 0, 0};
      const double there = spring.k_t * 0.002;
      Forecast f;
      f.current_D_W.force = f.predicted_D_W[0].force = {3, 0, 0};
      f.horizon = 0.01;
      double ticks = 0;
      for (int ms = 0; ms < 300; ++ms) {
        subject.sample(ms, handle);
        // They differ while they are shown first, and a new one makes no jump.
        const double swing = ms < 160 ? (ms % 20 == 0 ? 0.5 : -0.5) : 0;
        f.current_D_W.force.x = f.predicted_D_W[0].force.x = 3 + swing;
        if (forecasts && ms % 10 == 4) subject.forecast(ms - 8, ms, f);
        // None from 50 to 230 ms: from 145 ms on the last one is 100 ms old.
        if (ms % 10 == 0 && (ms < 50 || ms > 230))
          subject.model(ms + 5 - 10, ms, model_at(ms, one_body(tool), handle, wall));
        BOOST_REQUIRE(subject.tick(ms));
        if (ms > 0) BOOST_TEST(subject.jump() < 1e-6);
        const bool away = ms >= 135 && ms < 240;
        ticks += away ? 1 : 0;
        const bool shown_forecast = away && touching && forecasts;
        // 20 time constants after a change nothing is left of what was before.
        if (ms == 130 || ms == 200 || ms == 299) {
          BOOST_TEST(std::abs(subject.force(ms + 1).x - (shown_forecast ? 3 : there)) < 1e-3);
        }
        // The stamp is the result's, so that the gate sees that nothing newer is known.
        if (away) BOOST_REQUIRE(subject.stamp.ns == at_ms(35).ns);
      }
      BOOST_TEST(subject.metric("rollout.forecast_ticks") == (touching && forecasts ? ticks : 0.0));
      BOOST_TEST(subject.metric("rollout.held_ticks") == (touching && forecasts ? 0.0 : ticks));
      BOOST_TEST(subject.metric("rollout.jacobian_ticks") == 0.0);
      BOOST_TEST(subject.metric("rollout.ticks") == 300 - ticks);
      BOOST_TEST(subject.metric("fallbacks") == ticks);
    }
  }
}

BOOST_AUTO_TEST_CASE(a_tool_far_from_where_contacts_were_looked_for_is_not_gone_on_with) {
  Subject subject;
  const LocalContacts wall = wall_around({{0.02, 0, 0}});
  for (int ms = 0; ms < 100; ++ms) {
    const Vec3 handle{0.02 + 0.0005 * ms, 0, 0};
    subject.sample(ms, handle, {0.5, 0, 0});
    if (ms == 0) subject.model(-5, 0, model_at(0, one_body(handle, {0.5, 0, 0}), handle, wall, {0.5, 0, 0}));
    BOOST_REQUIRE(subject.tick(ms));
    BOOST_TEST(norm(subject.force(ms + 1)) < 0.05);
  }
  // 2 cm are 40 ms of the way.
  BOOST_TEST(std::abs(subject.metric("rollout.held_ticks") - 60) <= 1);
}

namespace {

/// Friction that overflows: the next step has no solution. The Jacobian leaves friction out.
LocalModel failing(LocalModel m) {
  m.contacts.contact[0][0].friction = 1e308;
  return m;
}

}  // namespace

BOOST_AUTO_TEST_CASE(where_a_step_fails_the_force_follows_the_handle_by_the_springs_in_series) {
  Subject subject;
  const LocalContacts wall = wall_around({{0.0094, 0, 0}}, 1000);
  const auto handle = [](double ms) { return Vec3{0.0082 - 1e-5 * std::max(0.0, ms - 100), 0, 0}; };
  for (int ms = 0; ms < 160; ++ms) {
    const double speed = ms > 100 ? -0.01 : 0;
    subject.sample(ms, handle(ms), {speed, 0, 0});
    const LocalModel good = model_at(ms, one_body({0.0094, 0, 0}), handle(ms), wall);
    if (ms == 0) subject.model(-5, 0, good);
    if (ms == 90) subject.model(85, ms, good);
    if (ms == 100) {
      LocalModel bad = failing(good);
      bad.time = at_ms(ms - 1);
      subject.model(95, ms, bad);
    }
    if (ms == 130)
      subject.model(125, ms, model_at(ms - 1, one_body({0.0093, 0, 0}), handle(ms - 1), wall, {-0.01, 0, 0}));
    BOOST_REQUIRE(subject.tick(ms));
    if (ms > 0) BOOST_TEST(subject.jump() < 0.02);
    const double in_series = 500.0 * 1000 / 1500, entered = 1e-5 * (ms + 1 - 100);
    if (ms < 130) BOOST_TEST(std::abs(subject.force(ms + 1).x - 0.6 - (ms > 100 ? in_series * entered : 0)) < 1e-6);
  }
  BOOST_TEST(subject.metric("rollout.jacobian_ticks") == 30.0);
  BOOST_TEST(subject.metric("rollout.ticks") == 130.0);
}

BOOST_AUTO_TEST_CASE(where_a_step_has_failed_the_contact_that_is_left_does_not_pull) {
  Subject subject;
  const LocalContacts wall = wall_around({{0.0094, 0, 0}}, 1000);
  for (int ms = 0; ms < 250; ++ms) {
    const Vec3 handle{0.0082 + 2e-4 * std::max(0, ms - 100), 0, 0}, v{ms > 100 ? 0.2 : 0.0, 0, 0};
    subject.sample(ms, handle, v);
    const LocalModel good = model_at(ms, one_body({0.0094, 0, 0}), handle, wall);
    if (ms == 0 || ms == 90) subject.model(ms - 5, ms, good);
    if (ms == 100) {
      LocalModel bad = failing(good);
      bad.time = at_ms(ms - 1);
      subject.model(95, ms, bad);
    }
    BOOST_REQUIRE(subject.tick(ms));
    if (ms > 0) BOOST_TEST(subject.jump() < 0.1);
    if (ms == 100) BOOST_TEST(subject.force(ms + 1).x > 0.5);
    if (ms > 105) BOOST_TEST(subject.force(ms + 1).x > -1e-3);
    if (ms > 130) BOOST_TEST(std::abs(subject.force(ms + 1).x) < 1e-3);
  }
  // 2 cm from where it failed the Jacobian is left.
  BOOST_TEST(subject.metric("rollout.jacobian_ticks") == 100.0);
  BOOST_TEST(subject.metric("rollout.held_ticks") == 50.0);
}

BOOST_AUTO_TEST_CASE(a_step_that_fails_while_something_else_is_displayed_goes_on_from_no_old_force) {
  auto params = anchored();
  params.trust_time = params.trust_time_max = Duration::from_seconds(0.1);
  Subject subject(0.1, params);
  const LocalContacts wall = wall_around({{0.0094, 0, 0}}, 1000);
  for (int ms = 0; ms < 400; ++ms) {
    // Pressed, then led away while no results come.
    const Vec3 handle{ms < 150 ? 0.0082 : 0.0182, 0, 0};
    subject.sample(ms, handle);
    if (ms == 0 || ms == 40) subject.model(ms - 5, ms, model_at(ms, one_body({0.0094, 0, 0}), handle, wall));
    if (ms == 300) {
      LocalModel bad = failing(model_at(ms - 1, one_body({0.0099, 0, 0}), handle, wall_around({{0.0099, 0, 0}}, 1000)));
      subject.model(295, ms, bad);
    }
    BOOST_REQUIRE(subject.tick(ms));
  }
  BOOST_TEST(subject.metric("rollout.jacobian_ticks") == 0.0);
  BOOST_TEST(subject.metric("rollout.held_ticks") > 200.0);
}

BOOST_AUTO_TEST_CASE(a_first_model_whose_step_fails_shows_no_force) {
  Subject subject;
  const Vec3 handle{0.0095, 0.2, -0.1};
  for (int ms = 0; ms < 20; ++ms) {
    subject.sample(ms, handle);
    if (ms == 1) subject.model(-5, 1, failing(model_at(0, one_body(handle), handle, wall_around({handle}))));
    if (subject.tick(ms)) BOOST_TEST(norm(subject.force(ms + 1)) == 0.0);
  }
  BOOST_TEST(subject.metric("rollout.held_ticks") == 19.0);
}

BOOST_AUTO_TEST_CASE(after_a_gap_a_tick_takes_four_steps_at_most) {
  Subject subject;
  const LocalContacts wall = wall_around({{0.009, 0, 0}});
  const auto state = [](int ms) { return DeviceState{{{0.0095 - 4e-5 * ms, 0, 0}, {}}, {{-0.04, 0, 0}, {}}, 0}; };
  const LocalModel model = model_at(0, one_body({0.0095, 0, 0}), state(0).X_WD.p, wall, {-0.04, 0, 0});
  const Scene scene = ball_scene(0.1);
  SystemModel system = scene_model("test", scene, nullptr);
  system.iterations = anchored().iterations;
  LocalRollout apart(system);
  BOOST_REQUIRE(apart.restart(model));
  for (int ms = 0; ms <= 40; ++ms) {
    subject.sample(ms, state(ms));
    if (ms > 0 && ms % 10 == 0) BOOST_REQUIRE(apart.advance({{at_ms(ms), at_ms(ms), 0}, state(ms)}));
  }
  subject.model(-2, 40, model);
  BOOST_REQUIRE(subject.tick(40));
  BOOST_TEST(norm(subject.force(40) - coupling_wrench(spring, apart.state(), false).force) < 1e-12);
}

BOOST_AUTO_TEST_CASE(models_that_are_no_use_are_counted_once_and_what_was_known_is_gone_on_with) {
  Subject subject(1e12);
  const Vec3 tool{0.002, 0, 0};
  LocalModel good = model_at(0, one_body(tool), {}, {});
  LocalModel two = good;
  two.bodies.count = 2;
  subject.sample(0, Vec3{});
  subject.model(-5, 0, two);
  BOOST_TEST(!subject.tick(0));
  BOOST_TEST(!subject.tick(0.5));
  BOOST_TEST(subject.metric("rollout.rejected_models") == 1.0);
  subject.model(-5, 1, good);
  subject.sample(1, Vec3{});
  BOOST_REQUIRE(subject.tick(1));
  LocalModel early = good;
  early.time = at_ms(10);
  early.bodies.X_WB[0].p = {0.004, 0, 0};
  for (int ms = 2; ms < 100; ++ms) {
    subject.sample(ms, Vec3{});
    if (ms == 5) subject.model(0, ms, two);
    if (ms == 7) subject.model(0, ms, early);
    BOOST_REQUIRE(subject.tick(ms));
    // One of a time to come is used when that has come.
    if (ms < 10) BOOST_TEST(subject.force(ms + 1).x == 1.0, tt::tolerance(1e-9));
  }
  BOOST_TEST(subject.force(100).x == 2.0, tt::tolerance(1e-6));
  BOOST_TEST(subject.metric("rollout.rejected_models") == 3.0);
}

BOOST_AUTO_TEST_CASE(whatever_comes_the_force_is_finite_and_bounded_and_soon_right_again) {
  constexpr double inf = std::numeric_limits<double>::infinity();
  const double odd[] = {std::nan(""), inf, -inf, 1e300, -1e200, 1e30, 1e8, 0};
  const LocalContacts wall = wall_around({{0.009, 0, 0}, {0.0088, 0, 0}, {0.0086, 0, 0}});
  for (int trial = 0; trial < 60; ++trial) {
    Dice dice(static_cast<std::uint64_t>(trial) + 1);
    Subject troubled, calm;
    for (int ms = 0; ms < 600; ++ms) {
      const double t = 1e-3 * ms;
      const DeviceState clean{{{0.009 + 0.001 * std::sin(9 * t), 0, 0}, {}}, {{0.009 * std::cos(9 * t), 0, 0}, {}}, 0};
      const bool hostile = ms < 300 && dice(0, 1) < 0.05;
      const double value = odd[static_cast<int>(dice(0, 7.999))];
      DeviceState state = clean;
      LocalModel model = model_at(ms - 2, one_body({0.0093, 0, 0}), clean.X_WD.p, wall, clean.V_WD.v);
      const LocalModel good = model;
      if (hostile) {
        switch (static_cast<int>(dice(0, 7.999))) {
          case 0:
            state.X_WD.p.y = value;
            break;
          case 1:
            state.V_WD.v.x = value;
            break;
          case 2:
            state.X_WD.R.w = value;
            break;
          case 3:
            model.bodies.X_WB[0].p.x = value;
            break;
          case 4:
            model.bodies.V_WB[0].v.z = value;
            break;
          case 5:
            model.coupling.k_t = value;
            break;
          case 6:
            model.contacts.contact[0][1].stiffness = model.contacts.contact[0][0].stiffness = value;
            break;
          default:
            model.contacts.contact[0][2].distance = value;
            break;
        }
      }
      calm.sample(ms, clean);
      // Some samples come twice, or late.
      troubled.sample(hostile && dice(0, 1) < 0.3 ? ms - 3 : ms, state);
      if (ms % 12 == 0) {
        calm.model(ms - 15, ms, good);
        troubled.model(ms - 15, ms, model);
      }
      calm.tick(ms);
      if (!troubled.tick(ms)) continue;
      for (const double later : {0.0, 0.4, 1.0}) {
        const Vec3 force = troubled.force(ms + later);
        BOOST_REQUIRE_MESSAGE(is_finite(force), trial << ", " << ms << " ms");
        BOOST_REQUIRE_MESSAGE(norm(force) < 4 * spring.force_max, trial << ", " << ms << " ms: " << norm(force));
      }
      if (ms > 400) {
        // What is left is the memory of how far forces could be carried on.
        BOOST_REQUIRE_MESSAGE(norm(troubled.force(ms + 1) - calm.force(ms + 1)) < 2e-3, trial << ", " << ms << " ms");
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(no_tick_calls_the_heap, *boost::unit_test::precondition(tactor::test::heap_is_counted)) {
  Rollout::Params params = anchored();
  params.trust_time = Duration::from_seconds(0.1);
  BOOST_TEST(Rollout::declare().realtime_safe);
  Subject subject(0.1, params, true);
  const LocalContacts wall = wall_around({{0.009, 0, 0}, {0.0088, 0, 0}, {0.0086, 0, 0}});
  Forecast f;
  f.horizon = 0.01;
  std::int64_t calls = 0;
  for (int ms = 0; ms < 500; ++ms) {
    subject.sample(ms, Vec3{0.009 + 0.001 * std::sin(0.02 * ms), 0, 0});
    // With results, without, and with one that fails.
    if (ms % 10 == 0 && ms / 150 != 1)
      subject.model(ms - 12, ms, model_at(ms - 2, one_body({0.0093, 0, 0}), {0.009, 0, 0}, wall));
    if (ms == 405) subject.model(ms - 12, ms, failing(model_at(ms - 2, one_body({0.0093, 0, 0}), {0.009, 0, 0}, wall)));
    if (ms % 10 == 5) subject.forecast(ms - 8, ms, f);
    const std::int64_t before = thread_heap_calls();
    subject.tick(ms);
    calls += thread_heap_calls() - before;
  }
  BOOST_TEST(calls == 0);
  BOOST_TEST(subject.metric("rollout.forecast_ticks") > 0);
  BOOST_TEST(subject.metric("rollout.jacobian_ticks") > 0);
}

// Physics of 10 Hz: no result is ever young enough to go on from, and each is shown as it comes.
BOOST_AUTO_TEST_CASE(results_too_old_to_go_on_from_are_held_one_after_the_other) {
  Rollout::Params params = anchored();
  params.trust_time = params.trust_time_max = Duration::from_seconds(0.05);
  Subject subject(1e12, params, false);
  const LocalContacts wall = wall_around({{0.009, 0, 0}});
  for (int ms = 0; ms < 500; ++ms) {
    const double pressed = 0.001 * (1 + ms / 100);
    const Vec3 tool{0.009, 0, 0}, handle = tool - Vec3{pressed, 0, 0};
    subject.sample(ms, handle);
    if (ms % 100 == 0) subject.model(ms - 90, ms, model_at(ms, one_body(tool), handle, wall));
    BOOST_REQUIRE(subject.tick(ms));
    if (ms % 100 == 99) BOOST_TEST(std::abs(subject.force(ms + 1).x - spring.k_t * pressed) < 1e-3);
  }
  BOOST_TEST(subject.metric("rollout.held_ticks") == 500.0);
}

// A handle that is no longer heard of has not gone on for ever.
BOOST_AUTO_TEST_CASE(the_force_is_carried_on_for_two_ticks_beyond_the_newest_sample_and_no_further) {
  Subject subject(1e12, anchored(), false);
  const LocalContacts wall = wall_around({{0.009, 0, 0}});
  double last = 0;
  for (int ms = 0; ms < 90; ++ms) {
    const Vec3 tool{0.009, 0, 0}, handle{0.009 - 0.0001 * ms, 0, 0};
    if (ms < 50) subject.sample(ms, handle, {-0.1, 0, 0});
    if (ms == 0) subject.model(-10, ms, model_at(ms, one_body(tool), handle, wall));
    BOOST_REQUIRE(subject.tick(ms));
    if (ms == 52) last = subject.force(ms + 1).x;
  }
  BOOST_TEST(std::abs(subject.force(90).x - last) < 0.05 * std::abs(last));
}

// What is displayed goes from one side to the other without passing either.
BOOST_AUTO_TEST_CASE(a_correction_does_not_swing_past_what_it_leads_to) {
  Subject subject(1e12, anchored(), false);
  const LocalContacts wall = wall_around({{0.009, 0, 0}});
  double lowest = 1e9;
  for (int ms = 0; ms < 100; ++ms) {
    // Comes in fast, and the result at 50 ms says that it has long gone.
    const Vec3 tool{ms < 50 ? 0.009 : 0.02, 0, 0};
    const Vec3 handle = ms < 50 ? Vec3{0.009 - 0.0001 * ms, 0, 0} : tool;
    subject.sample(ms, handle, ms < 50 ? Vec3{-0.1, 0, 0} : Vec3{});
    if (ms % 10 == 0) subject.model(ms - 10, ms, model_at(ms, one_body(tool), handle, wall));
    BOOST_REQUIRE(subject.tick(ms));
    if (ms >= 60) lowest = std::min(lowest, subject.force(ms + 1).x);
  }
  BOOST_TEST(lowest > -0.01);
}

BOOST_AUTO_TEST_CASE(integrator_and_stick_velocity_are_those_of_dynamics_unless_a_graph_gives_them) {
  const NodeInfo info = Rollout::declare();
  for (const std::string name : {"integrator", "stick_velocity"}) {
    const auto param =
        std::find_if(info.params.begin(), info.params.end(), [&](const ParamInfo& p) { return p.name == name; });
    BOOST_REQUIRE((param != info.params.end()));
    BOOST_TEST((param->as_in == Role::dynamics));
  }
}

BOOST_AUTO_TEST_SUITE_END()
