// The stages in a loop with a handle and a sampled wall, whose energy is summed up here by the true motion.
#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <utility>

#include "framework/core/segment.hpp"
#include "framework/realtime/allocation_watch.hpp"
#include "nodes/passivity/controller.hpp"
#include "nodes/passivity/energy_bound.hpp"
#include "tests/support/force_stream.hpp"
#include "tests/support/heap_is_counted.hpp"
#include "tests/support/nodes.hpp"

BOOST_AUTO_TEST_SUITE(stage_test)

using namespace tactor;
using namespace tactor::test;

namespace {

constexpr Duration tick{1'000'000};
constexpr double T = 1e-3;  // s

/// `credit` false: without the share of the strict bound that may be given before the hand has given it.
std::unique_ptr<PassivityStage> make(const std::string& kind, bool credit = true, bool in_loop = false) {
  if (kind == "controller") {
    return std::make_unique<PassivityController>(default_params<PassivityController>(), context(true));
  }
  auto params = default_params<EnergyBound>();
  if (!credit) params.bound_share = 0;
  NodeContext of_stage = context(true);
  of_stage.in_loop = in_loop;
  return std::make_unique<EnergyBound>(params, of_stage);
}

const std::vector<std::string> kinds{"controller", "energy_bound"};

/// A stage with a device that commands what it sends.
struct Loop {
  explicit Loop(const std::string& kind, bool credit = true, bool in_loop = false)
      : stage(make(kind, credit, in_loop)) {
    stage->device.configure({QueuePolicy::drop_oldest, 64});
    stage->commanded.configure({QueuePolicy::drop_oldest, 64});
    stage->segment.configure({QueuePolicy::latest, 1});
  }
  /// A tick of the device: it shows the handle and commands what was sent; then the stage gets what is wanted.
  Wrench device_tick(const DeviceState& state) {
    commanded = evaluate(shown, now);
    const Stamp stamp{now, now, n};
    stage->device.push(stamp, &state);
    stage->commanded.push(stamp, &commanded);
    return commanded;
  }
  void stage_tick(const ForceSegment& wanted) {
    stage->segment.push({now, now, n}, &wanted);
    step();
    now = now + tick;
    ++n;
  }
  /// A tick of both in lanes of their own: neither hears in it what the other sends.
  Wrench tick_of_both(const DeviceState& state, const ForceSegment& wanted) {
    const ForceSegment before = shown;
    stage->segment.push({now, now, n}, &wanted);
    step();
    const ForceSegment later = std::exchange(shown, before);
    device_tick(state);
    shown = later;
    now = now + tick;
    ++n;
    return commanded;
  }
  void step() {
    StepContext c(now);
    stage->step(c);
    sent = stage->limited.pending();
    if (sent > 0) {
      shown = *static_cast<const ForceSegment*>(stage->limited.pending_value(0));
      valid = stage->limited.pending_valid(0);
    }
    stage->limited.clear_pending();
  }
  std::unique_ptr<PassivityStage> stage;
  ForceSegment shown;
  Time valid, now;
  Wrench commanded;
  std::uint64_t n = 0;
  std::size_t sent = 0;
};

struct Given {
  double most = 0;     // J, net, by the true motion
  double allowed = 0;  // J
  double wanted_most = 0;
};

/// Handle and hand of 0.3 kg and damping b on a sampled wall of stiffness K at z = 0, pressed by 1 N and thrown at it
/// with 0.1 m/s. Explicit integration in 100 steps a tick. `kind` empty: without a stage. `lanes`: the stage hears of
/// the handle a tick late, and what it sends acts a tick later too.
Given bounce(const std::string& kind, double K, double b, bool lanes = false) {
  constexpr double mass = 0.3, push = -1, D = 1e-5;
  std::unique_ptr<Loop> loop = kind.empty() ? nullptr : std::make_unique<Loop>(kind);
  double x = 1e-3, v = -0.1, force = 0, next = 0, wanted_before = 0, net = 0, largest = 0, of_a_tick = 0,
         shown_before = x, shown_v = v;
  Given found;
  for (int n = 0; n < 3000; ++n) {
    const double shown = D * std::round(x / D);
    shown_v += 0.3 * ((shown - shown_before) / T - shown_v);  // as a filter that is late
    shown_before = shown;
    const double wanted = std::min(8.0, shown < 0 ? -K * shown : 0.0);
    if (loop) {
      DeviceState state;
      state.X_WD.p.z = shown;
      state.V_WD.v.z = shown_v;
      if (lanes) {
        force = loop->tick_of_both(state, constant_segment(loop->now, {{0, 0, wanted_before}, {}})).force.z;
      } else {
        force = loop->device_tick(state).force.z;
        loop->stage_tick(constant_segment(loop->now, {{0, 0, wanted}, {}}));
      }
      wanted_before = wanted;
    } else {
      force = next;
      next = wanted;
    }
    const double from = x;
    for (int i = 0; i < 100; ++i) {
      v += 1e-2 * T / mass * (force + push - b * v);
      x += 1e-2 * T * v;
    }
    net += force * (x - from);
    found.most = std::max(found.most, net);
    largest = std::max(largest, std::abs(force));
    of_a_tick = std::max(of_a_tick, std::abs(force * (x - from)));
  }
  found.allowed = largest * D + of_a_tick;
  return found;
}

}  // namespace

BOOST_AUTO_TEST_CASE(where_a_method_displays_no_weight_the_bound_adds_none) {
  Scene scene;  // with gravity
  Body tool;
  tool.name = scene.tool_name = "tool";
  tool.motion = Motion::translation;
  tool.mass = 1;
  scene.bodies.push_back(tool);
  BOOST_REQUIRE(dot(scene.gravity_W, Vec3{0, 0, -1}) > 9);
  NodeContext with_weight = context(false);
  with_weight.scene = &scene;
  Loop loop("energy_bound");
  loop.stage = std::make_unique<EnergyBound>(default_params<EnergyBound>(), with_weight);
  loop.stage->device.configure({QueuePolicy::drop_oldest, 64});
  loop.stage->commanded.configure({QueuePolicy::drop_oldest, 64});
  loop.stage->segment.configure({QueuePolicy::latest, 1});
  double least = 0, most = 0, last = 0;
  // A wall pushes a handle out that has given nothing.
  for (int n = 0; n < 200; ++n) {
    DeviceState state;
    state.X_WD.p.z = 1e-4 * n;
    state.V_WD.v.z = 0.1;
    last = loop.device_tick(state).force.z;
    least = std::min(least, last);
    most = std::max(most, last);
    loop.stage_tick(constant_segment(loop.now, {{0, 0, 5}, {}}));
  }
  BOOST_TEST(least == 0);
  BOOST_TEST(most <= 5);
  BOOST_TEST(last < 5);  // it is limited
}

BOOST_AUTO_TEST_CASE(a_sampled_wall_beyond_its_passive_stiffness_is_active_without_and_passive_with_a_stage) {
  // A sampled spring is passive up to 2 b / T without delay; these are stiffer, and a tick late.
  for (const double b : {0.2, 1.0}) {
    for (const double times : {4.0, 20.0}) {
      const double K = times * 2 * b / T;
      const Given without = bounce("", K, b);
      BOOST_TEST(without.most > 10 * without.allowed, "b " << b << ", K " << K << ": " << without.most);
      for (const std::string& kind : kinds) {
        const Given with = bounce(kind, K, b);
        BOOST_TEST(with.most <= with.allowed,
                   kind << ", b " << b << ", K " << K << ": " << with.most << " J of " << with.allowed);
        const Given late = bounce(kind, K, b, true);
        BOOST_TEST(late.most <= late.allowed,
                   kind << " in lanes, b " << b << ", K " << K << ": " << late.most << " J of " << late.allowed);
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(a_passive_force_goes_through_as_it_came_with_its_stamp_and_trust) {
  for (const std::string& kind : kinds) {
    Loop loop(kind);
    for (int i = 0; i < 200; ++i) {
      // A hand presses a spring of 500 N/m by 5 mm and lets it out by half.
      const double s = i < 100 ? i / 100.0 : 1.0 - 0.5 * (i - 100) / 100.0;
      DeviceState state;
      state.X_WD.p.x = -0.005 * s;
      state.V_WD.v.x = i < 100 ? -0.05 : 0.025;
      loop.device_tick(state);
      ForceSegment wanted{loop.now, loop.now + tick, {Wrench{{2.5 * s, 0, 0}, {}}, Wrench{{0.01, 0, 0}, {}}}};
      wanted.trust_time = tick * 300;
      loop.stage_tick(wanted);
      BOOST_TEST_REQUIRE(loop.sent == 1U);
      BOOST_TEST(loop.shown.c[0].force.x == wanted.c[0].force.x, kind);
      BOOST_TEST(loop.shown.c[1].force.x == wanted.c[1].force.x);
      BOOST_TEST((loop.shown.begin == wanted.begin && loop.shown.end == wanted.end));
      BOOST_TEST((loop.shown.trust_time == wanted.trust_time));
      BOOST_TEST((loop.valid == loop.now + Duration{-tick.ns}));
    }
    loop.now = loop.now + Duration{-tick.ns};
    loop.step();
    BOOST_TEST(loop.sent == 0U, "a segment that went through is not sent again");
  }
}

BOOST_AUTO_TEST_CASE(a_force_without_energy_behind_it_is_cut_and_keeps_stamp_and_trust) {
  for (const std::string& kind : kinds) {
    Loop loop(kind, false);
    double given = 0, x = 0;
    for (int i = 0; i < 1000; ++i) {
      // The handle goes along at 0.1 m/s, and a force wants to push it on.
      DeviceState state;
      const double before = x;
      x = 1e-4 * i;
      given += loop.commanded.force.x * (x - before);
      state.X_WD.p.x = x;
      state.V_WD.v.x = 0.1;
      loop.device_tick(state);
      ForceSegment wanted = constant_segment(loop.now, {{3, 0, 0}, {}});
      wanted.trust_time = tick * 300;
      loop.stage_tick(wanted);
      if (loop.sent > 0) BOOST_TEST((loop.shown.trust_time == wanted.trust_time));
    }
    BOOST_TEST(given <= default_params<EnergyBound>().start_energy + 1e-12, kind << ": " << given);
  }
}

BOOST_AUTO_TEST_CASE(a_bound_whose_loop_may_miss_a_tick_allows_less_though_it_hears_the_handle_in_time) {
  // The hand gives energy against 0.4 N, then goes along with 4 N until nothing is left.
  Loop in_loop("energy_bound", false, true), beside("energy_bound", false, false);
  DeviceState state;
  for (int i = 0; i < 300 && in_loop.commanded.force == beside.commanded.force; ++i) {
    state.V_WD.v.x = i < 100 ? -0.1 : 0.1;
    state.X_WD.p.x += T * state.V_WD.v.x;
    for (Loop* loop : {&in_loop, &beside}) {
      loop->device_tick(state);
      loop->stage_tick(constant_segment(loop->now, {{i < 98 ? 0.4 : 4, 0, 0}, {}}));
    }
  }
  BOOST_TEST(in_loop.commanded.force.x < beside.commanded.force.x);
}

BOOST_AUTO_TEST_CASE(in_debt_nothing_but_a_force_against_the_motion_is_commanded) {
  for (const std::string& kind : kinds) {
    Dice draw(8);
    Loop loop(kind);
    Vec3 p;
    // A debt by a gate that commands what the stage did not send.
    DeviceState state;
    loop.device_tick(state);
    loop.shown = constant_segment(loop.now, {{5, 0, 0}, {}});
    loop.now = loop.now + tick;
    ++loop.n;
    loop.device_tick(state);
    state.X_WD.p.x = p.x = 0.01;
    loop.now = loop.now + tick;
    ++loop.n;
    for (int i = 0; i < 200; ++i) {
      state.V_WD.v = draw.normal_vector(0.01);
      p += T * state.V_WD.v;
      state.X_WD.p = p;
      loop.device_tick(state);
      loop.stage_tick(constant_segment(loop.now, {5.0 * state.V_WD.v / norm(state.V_WD.v), {}}));
      const Vec3 force = evaluate(loop.shown, loop.now).force;
      BOOST_TEST(dot(force, state.V_WD.v) <= 1e-15, kind);
      // By the controller's damper, as far as the mass bears it: 0.3 of 0.1 kg / 1 ms.
      BOOST_TEST(norm(force) <= 30 * norm(state.V_WD.v) * (1 + 1e-12), kind);
    }
  }
}

BOOST_AUTO_TEST_CASE(in_debt_a_force_against_the_motion_stays_where_it_gives_nothing_on_its_way_down) {
  Loop loop("controller");
  DeviceState state;
  state.V_WD.v.x = -0.2;
  loop.device_tick(state);
  loop.shown = constant_segment(loop.now, {{-5, 0, 0}, {}});
  for (int i = 0; i < 2; ++i) {
    loop.now = loop.now + tick;
    ++loop.n;
    state.X_WD.p.x -= 1e-2;
    loop.device_tick(state);
  }
  // It has got 50 mJ from the device, and its wall pushes back now: 2 N are down in a tick of 2 N, long before it
  // turns.
  loop.stage_tick(constant_segment(loop.now, {{2, 0, 0}, {}}));
  BOOST_TEST(evaluate(loop.shown, loop.now).force.x >= 2);
  // At rest a force could be going with the handle by the next tick.
  state.V_WD.v.x = -1e-9;
  loop.device_tick(state);
  loop.stage_tick(constant_segment(loop.now, {{2, 0, 0}, {}}));
  BOOST_TEST(evaluate(loop.shown, loop.now).force.x < 1e-3);
}

BOOST_AUTO_TEST_CASE(a_wrench_on_its_way_to_the_device_is_charged) {
  // The hand gives energy, then turns round and goes faster and faster with a force of 4 N.
  for (const bool lanes : {false, true}) {
    Loop loop("energy_bound", false);
    double given = 0, most = 0, x = 0;
    DeviceState state;
    for (int i = 0; i < 300; ++i) {
      const double v = i < 100 ? -0.1 : std::min(1.0, -0.1 + 0.05 * (i - 100));
      state.X_WD.p.x = x;
      state.V_WD.v.x = v;
      const ForceSegment wanted = constant_segment(loop.now, {{i < 98 ? 0.4 : 4, 0, 0}, {}});
      if (lanes) {
        loop.tick_of_both(state, wanted);
      } else {
        loop.device_tick(state);
        loop.stage_tick(wanted);
      }
      most = std::max(most, loop.commanded.force.x);
      given += loop.commanded.force.x * T * v;
      x += T * v;
      BOOST_TEST(given <= default_params<EnergyBound>().start_energy + 1e-12, i << (lanes ? ", lanes" : ""));
    }
    BOOST_TEST(most == 4);
  }
}

BOOST_AUTO_TEST_CASE(after_sixteen_ticks_without_a_state_nothing_is_commanded) {
  for (const std::string& kind : kinds) {
    Loop loop(kind);
    DeviceState state;
    for (int i = 0; i < 100; ++i) {
      state.X_WD.p.x = -1e-4 * i;
      state.V_WD.v.x = -0.1;
      loop.device_tick(state);
      loop.stage_tick(constant_segment(loop.now, {{1, 0, 0}, {}}));
    }
    BOOST_TEST(evaluate(loop.shown, loop.now).force.x > 0);
    for (int i = 0; i < 16; ++i) loop.stage_tick(constant_segment(loop.now, {{1, 0, 0}, {}}));
    BOOST_TEST(evaluate(loop.shown, loop.now).force.x == 0, kind);
  }
}

BOOST_AUTO_TEST_CASE(a_bound_that_was_later_than_it_foresees_says_so_after_the_run) {
  const auto reported = [](int without_state, int without_step) {
    Loop loop("energy_bound");
    const ForceSegment wanted = constant_segment({}, {{1, 0, 0}, {}});
    DeviceState state;
    for (int i = 0; i < 20; ++i) loop.tick_of_both(state, wanted);
    for (int i = 0; i < without_state; ++i) loop.stage_tick(wanted);
    for (int i = 0; i < without_step; ++i, loop.now = loop.now + tick) loop.device_tick(state);
    for (int i = 0; i < 20; ++i) loop.tick_of_both(state, wanted);
    return report_of(static_cast<const EnergyBound&>(*loop.stage));
  };
  const auto metric = [](const Report& report, const std::string& name) {
    return metrics_of(report).at("passivity." + name);
  };
  const Report on_time = reported(2, 1), no_states = reported(4, 0), no_steps = reported(0, 4);
  BOOST_TEST(metric(on_time, "ahead_most") == 3);
  BOOST_TEST(metric(on_time, "held_most") == 2);
  BOOST_TEST(on_time.remarks().empty());
  BOOST_TEST(metric(no_states, "ahead_most") == 6);
  BOOST_TEST(metric(no_states, "held_most") == 1);
  BOOST_TEST(no_states.remarks().size() == 1);
  BOOST_TEST(metric(no_steps, "held_most") == 5);
  BOOST_TEST(metric(no_steps, "ahead_most") == 2);
  BOOST_TEST(no_steps.remarks().size() == 1);
}

BOOST_AUTO_TEST_CASE(what_is_not_finite_goes_through_and_is_forgotten) {
  for (const std::string& kind : kinds) {
    Loop loop(kind);
    loop.stage_tick(constant_segment(loop.now, {{1, 0, 0}, {}}));
    BOOST_TEST(loop.sent == 0U, "the device has shown nothing yet");
    for (int i = 0; i < 10; ++i) {
      loop.device_tick({});
      loop.commanded = {};
      const double x = i == 5 ? std::numeric_limits<double>::quiet_NaN() : 0.5;
      loop.shown = {};
      loop.stage_tick(constant_segment(loop.now, {{x, 0, 0}, {}}));
      BOOST_TEST(std::isfinite(evaluate(loop.shown, loop.now).force.x) == (i != 5), kind);
      loop.shown = {};
    }
  }
}

BOOST_AUTO_TEST_CASE(no_step_of_a_stage_calls_the_heap,
                     *boost::unit_test::precondition(tactor::test::heap_is_counted)) {
  for (const std::string& kind : kinds) {
    Dice draw(3);
    Loop loop(kind);
    std::int64_t before = 0;
    DeviceState state;
    for (int i = 0; i < 1000; ++i) {
      if (i == 100) before = thread_heap_calls();
      state.V_WD = {draw.normal_vector(0.1), draw.normal_vector(1)};
      state.X_WD.p += T * state.V_WD.v;
      loop.device_tick(state);
      loop.stage_tick(constant_segment(loop.now, {draw.normal_vector(4), draw.normal_vector(0.1)}));
    }
    BOOST_TEST(thread_heap_calls() - before == 0, kind);
  }
}

BOOST_AUTO_TEST_SUITE_END()
