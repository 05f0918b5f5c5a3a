// A device node reads, evaluates, passes the gate, writes and tells; a scripted device stands in for a real one.
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <string>

#include "framework/core/check.hpp"
#include "framework/core/segment.hpp"
#include "framework/realtime/allocation_watch.hpp"
#include "framework/realtime/declare_device.hpp"
#include "tests/framework/realtime/gate_drive.hpp"
#include "tests/support/nodes.hpp"

BOOST_AUTO_TEST_SUITE(device_node_test)

using namespace tactor;
using tactor::test::ramp;

namespace {

constexpr Duration ms{1'000'000};

/// Answers as the test says.
class ScriptedDevice final : public DeviceNode {
 public:
  struct Params : DeviceParams {};
  ScriptedDevice(const Params& params, const NodeContext& context) : DeviceNode(params, context) {}
  static NodeInfo declare() {
    Declare<ScriptedDevice> declaration("test.device", "Answers as it is told.");
    DeviceParams defaults;
    defaults.force_max = 5;
    declare_device(declaration, defaults);
    return declaration.info();
  }

  ReadResult answer = ReadResult::sample;
  DeviceSample shown;
  bool takes = true;
  Wrench taken;
  int writes = 0;

 protected:
  ReadResult read(Time, DeviceSample& sample) noexcept override {
    sample = shown;
    return answer;
  }
  bool write(Time, const Wrench& commanded_D_W) noexcept override {
    ++writes;
    if (takes) taken = commanded_D_W;
    return takes;
  }
  [[nodiscard]] const char* failure() const noexcept override { return "the plug is out"; }
};

class Bench {
 public:
  explicit Bench(const std::map<std::string, ParamValue>& given = {}, bool torque = true) {
    const NodeInfo info = ScriptedDevice::declare();
    NodeContext context;
    context.name = "arm";
    context.scene = &scene_;
    context.torque = torque;
    node_ = info.create(test::param_values(info, given), context);
    device().segment.configure({QueuePolicy::latest, 1});
  }

  [[nodiscard]] ScriptedDevice& device() { return dynamic_cast<ScriptedDevice&>(*node_); }
  void send(const ForceSegment& s, Stamp stamp) { device().segment.push(stamp, &s); }
  /// A message that is newer than every one before.
  void send(const ForceSegment& s) { send(s, {now, now, sequence_++}); }
  void send(const Wrench& w) { send(constant_segment(now, w)); }

  /// One step at `now`, which then moves on; false where it asked for further ones.
  bool tick() {
    StepContext context(now, phase);
    device().shown.time = now;
    device().step(context);
    take();
    now = now + ms;
    return context.at_rest();
  }
  /// `n` ticks, each with a fresh segment of `w`.
  void feed(const Wrench& w, int n) {
    for (int i = 0; i < n; ++i) {
      send(w);
      tick();
    }
  }
  [[nodiscard]] std::map<std::string, double> metrics() const {
    Report report;
    report.ask(*node_, "device", ScriptedDevice::declare().metrics);
    return test::metrics_of(report);
  }

  Time now;
  Phase phase = Phase::running;
  std::optional<DeviceState> state;
  std::optional<Wrench> interpolated;
  Wrench commanded;
  SafetyState safety;

 private:
  template <class T>
  static std::optional<T> sent(Output<T>& out) {
    BOOST_REQUIRE(out.pending() <= 1U);
    std::optional<T> value;
    if (out.pending() == 1) value = *static_cast<const T*>(out.pending_value(0));
    out.clear_pending();
    return value;
  }
  void take() {
    state = sent(device().state);
    interpolated = sent(device().interpolated);
    commanded = sent(device().commanded).value();
    safety = sent(device().safety).value();
  }

  Scene scene_;
  std::unique_ptr<Node> node_;
  std::uint64_t sequence_ = 0;
};

bool is_zero(const Wrench& w) {
  return w.force == Vec3{} && w.torque == Vec3{};
}

const Wrench push{{0, 4, 0}, {0.1, 0, 0}};

}  // namespace

BOOST_AUTO_TEST_CASE(the_declaration_makes_an_actuator_with_the_ports_and_limits_of_every_device) {
  const NodeInfo info = ScriptedDevice::declare();
  BOOST_TEST(info.actuator);
  BOOST_TEST(info.realtime_safe);
  BOOST_TEST((info.lane == Lane::realtime));
  BOOST_REQUIRE(info.input("segment") != nullptr);
  BOOST_TEST(!info.input("segment")->required);
  BOOST_TEST(!info.input("segment")->in_reference);
  for (const char* name : {"state", "interpolated", "commanded", "safety"}) BOOST_TEST(info.output(name) != nullptr);
  BOOST_TEST(std::get<double>(info.params[info.param("force_max").value()].default_value.value()) == 5.0);
  BOOST_TEST(std::get<double>(info.params[info.param("stale_after").value()].default_value.value()) == 0.1);
  BOOST_TEST(info.rate_parameter.has_value());
}

BOOST_AUTO_TEST_CASE(limits_that_do_not_fit_together_are_refused) {
  BOOST_CHECK_EXCEPTION(Bench({{"force_slew", 50.0}}), InputError, [](const InputError& error) {
    return std::string(error.what()).find("force_slew: expected at least 75 N/s") == 0;
  });
}

BOOST_AUTO_TEST_CASE(a_tick_writes_the_segment_at_its_time_and_tells_every_stage) {
  Bench bench;
  bench.feed({}, 102);
  ForceSegment s;
  s.begin = bench.now;
  s.end = bench.now + ms * 10;
  s.c = {Wrench{{1, 0, 0}, {}}, Wrench{{4, 0, 0}, {}}, Wrench{{0, 0, 0}, {0, 0, 0.1}}, Wrench{{3, 0, 0}, {}}};
  bench.send(s);
  for (int i = 0; i < 20; ++i) {
    bench.device().shown.state.X_WD.p.x = 0.001 * i;
    bench.tick();
    const double u = std::min(i / 10.0, 1.0), x = 1 + 4 * u + 3 * u * u * u;
    BOOST_TEST(std::abs(bench.interpolated.value().force.x - x) < 1e-12);
    BOOST_TEST(std::abs(bench.safety.clamped_D_W.force.x - std::min(x, 5.0)) < 1e-12);
    BOOST_TEST(std::abs(bench.commanded.force.x - std::min(x, 5.0)) < 1e-12);
    BOOST_TEST(std::abs(bench.commanded.torque.z - 0.1 * u * u) < 1e-15);
    BOOST_TEST((bench.device().taken.force == bench.commanded.force));
    BOOST_TEST(bench.state.value().X_WD.p.x == 0.001 * i);
  }
  BOOST_TEST(bench.metrics().at("device.clamped_ticks") == 12.0);
  BOOST_TEST(bench.metrics().at("device.faults") == 0.0);
  BOOST_TEST(std::abs(bench.metrics().at("device.engaged_share") - 22.0 / 122.0) < 1e-12);
}

BOOST_AUTO_TEST_CASE(a_state_is_stamped_with_the_time_of_its_sample) {
  Bench bench;
  ScriptedDevice& device = bench.device();
  device.shown.time = Time{-300'000};
  StepContext context(Time{0});
  device.step(context);
  BOOST_TEST(device.state.pending_valid(0).ns == -300'000);
  BOOST_TEST(device.commanded.pending_valid(0).ns == 0);
}

BOOST_AUTO_TEST_CASE(only_newer_messages_with_sensible_times_count_as_fresh) {
  struct Bad {
    std::int64_t begin, end, produced;  // ns from now
    std::int64_t sequence;              // from the last
  };
  constexpr std::int64_t far = 61'000'000'000;
  constexpr std::int64_t earliest = std::numeric_limits<std::int64_t>::min();
  constexpr std::int64_t latest = std::numeric_limits<std::int64_t>::max();
  const Bad cases[] = {
      {0, -1, 0, 1}, {0, far, 0, 1}, {-far, 0, 0, 1}, {far, far, 0, 1},        {0, 0, -1'000'000'000, 1},
      {0, 0, 0, 0},  {0, 0, 0, -5},  {0, 0, far, 1},  {earliest, latest, 0, 1}};
  for (const Bad& bad : cases) {
    Bench bench;
    std::uint64_t sequence = 100;
    for (int i = 0; i < 150; ++i) {
      bench.send(constant_segment(bench.now, push), {bench.now, bench.now, sequence++});
      bench.tick();
    }
    BOOST_TEST((bench.commanded.force == push.force));
    // What it says is not followed, and the force goes as if nothing came.
    for (int i = 0; i < 199; ++i) {
      ForceSegment s = constant_segment(bench.now, {{-1, 0, 0}, {}});
      s.begin.ns = bad.begin == earliest ? earliest : bench.now.ns + bad.begin;
      s.end.ns = bad.end == latest ? latest : bench.now.ns + bad.end;
      Stamp stamp{bench.now, {bench.now.ns + bad.produced}, sequence - 1 + static_cast<std::uint64_t>(bad.sequence)};
      bench.send(s, stamp);
      bench.tick();
      BOOST_TEST(bench.commanded.force.x == 0.0);
    }
    BOOST_TEST(bench.commanded.force.y > 0);
    bench.tick();
    BOOST_TEST(is_zero(bench.commanded));
    BOOST_TEST(bench.metrics().at("device.rejected_segments") == 199.0);
    BOOST_TEST(bench.metrics().at("device.stale") == 1.0);
  }
}

BOOST_AUTO_TEST_CASE(the_same_message_is_not_fresh_twice) {
  Bench bench;
  bench.feed(push, 150);
  for (int i = 0; i < 300; ++i) bench.tick();
  BOOST_TEST(is_zero(bench.commanded));
  BOOST_TEST(bench.metrics().at("device.rejected_segments") == 0.0);
  BOOST_TEST((bench.safety.cause == SafetyCause::stale));
}

BOOST_AUTO_TEST_CASE(a_filter_that_goes_on_after_its_physics_has_died_keeps_no_force_alive) {
  Bench bench;
  bench.feed(push, 150);
  // New messages each tick, all made from the device sample that the physics used last.
  const Time last = bench.now;
  for (std::uint64_t i = 0; i < 300; ++i) {
    bench.send(constant_segment(bench.now, push), {last, bench.now, 1000 + i});
    bench.tick();
  }
  BOOST_TEST(is_zero(bench.commanded));
  BOOST_TEST(bench.metrics().at("device.rejected_segments") == 0.0);
  BOOST_TEST((bench.safety.cause == SafetyCause::stale));
}

BOOST_AUTO_TEST_CASE(a_force_made_from_an_old_sample_of_the_device_is_not_fresh) {
  for (const std::int64_t age_ms : {499, 500}) {
    Bench bench;
    bench.now = Time::from_seconds(10);
    for (std::uint64_t i = 0; i < 300; ++i) {
      bench.send(constant_segment(bench.now, push), {bench.now - Duration{age_ms * 1'000'000}, bench.now, i});
      bench.tick();
    }
    BOOST_TEST(is_zero(bench.commanded) == (age_ms == 500));
  }
}

namespace {

/// A pipeline that sends a segment each tick, made from the newest result of physics. Results come every `period_ms`,
/// each as old as that, until physics dies.
struct SlowPhysics {
  int period_ms = 125;
  Duration trust_time;
  int ms = 0;
  int newest_ms = 0;  // the time of the sample behind the newest result

  void tick(Bench& bench, bool alive) {
    if (alive && ms > 0 && ms % period_ms == 0) newest_ms = ms - period_ms;
    ForceSegment s = constant_segment(bench.now, push);
    s.trust_time = trust_time;
    bench.send(s, {Time{newest_ms * ms_ns}, bench.now, static_cast<std::uint64_t>(ms) + 1});
    bench.tick();
    ++ms;
  }
  static constexpr std::int64_t ms_ns = 1'000'000;
};

/// Ticks until zero is commanded, from the one on at which physics has died; 5,000 at most.
int ticks_to_zero(Bench& bench, SlowPhysics& physics) {
  for (int i = 0; i < 5000; ++i) {
    physics.tick(bench, false);
    if (is_zero(bench.commanded)) return i;
  }
  return 5000;
}

}  // namespace

BOOST_AUTO_TEST_CASE(slow_physics_keeps_its_force_while_it_lives_and_loses_it_when_its_trust_has_passed) {
  Bench bench({{"stale_after", 2.0}});
  SlowPhysics physics{.trust_time = ms * 375};
  for (int i = 0; i < 5000; ++i) {
    physics.tick(bench, true);
    if (i > 400) BOOST_REQUIRE(bench.commanded.force == push.force);
  }
  BOOST_TEST(bench.metrics().at("device.stale") == 0.0);
  // The newest result is that of 4.75 s: trusted until 5.125 s, and a ramp of 0.1 s. The ticks go on from 5 s.
  BOOST_TEST(physics.newest_ms == 4750);
  BOOST_TEST(ticks_to_zero(bench, physics) == 225);
  BOOST_TEST(bench.metrics().at("device.stale") == 1.0);
}

BOOST_AUTO_TEST_CASE(without_a_stated_trust_slow_physics_is_held_for_stale_after) {
  Bench bench({{"stale_after", 0.5}});
  SlowPhysics physics;
  for (int i = 0; i < 5000; ++i) physics.tick(bench, true);
  BOOST_TEST(bench.metrics().at("device.stale") == 0.0);
  // The newest result came at 4.875 s.
  BOOST_TEST(ticks_to_zero(bench, physics) == 475);
}

BOOST_AUTO_TEST_CASE(by_default_no_trust_lengthens_the_tenth_of_a_second) {
  constexpr std::int64_t most = std::numeric_limits<std::int64_t>::max();
  for (const std::int64_t trust : {std::int64_t{0}, std::int64_t{-1}, std::numeric_limits<std::int64_t>::min(),
                                   std::int64_t{250'000'000}, std::int64_t{60'000'000'000}, most}) {
    Bench slow;
    SlowPhysics physics{.trust_time = {trust}};
    for (int i = 0; i < 2000; ++i) physics.tick(slow, true);
    BOOST_TEST(slow.metrics().at("device.stale") > 10.0);

    Bench fast;
    physics = {.period_ms = 5, .trust_time = {trust}};
    for (int i = 0; i <= 2000; ++i) physics.tick(fast, true);
    BOOST_TEST(fast.metrics().at("device.stale") == 0.0);
    // The newest result came at 2 s, a tick before.
    BOOST_TEST(ticks_to_zero(fast, physics) == 199);
  }
}

BOOST_AUTO_TEST_CASE(a_sample_older_than_its_trust_is_not_fresh) {
  for (const std::int64_t trust : {std::int64_t{1}, std::int64_t{50'000'000}, std::int64_t{50'000'001}}) {
    Bench bench;
    bench.now = Time::from_seconds(10);
    for (std::uint64_t i = 0; i < 300; ++i) {
      ForceSegment s = constant_segment(bench.now, push);
      s.trust_time = {trust};
      bench.send(s, {bench.now - ms * 50, bench.now, i});
      bench.tick();
      if (trust <= 50'000'000) BOOST_REQUIRE(is_zero(bench.commanded));
    }
    // A nanosecond of trust is left at each tick.
    if (trust > 50'000'000) BOOST_TEST((bench.commanded.force == push.force));
  }
}

BOOST_AUTO_TEST_CASE(a_sample_of_the_future_is_trusted_for_no_longer_than_stale_after) {
  for (const std::int64_t trust : {std::int64_t{0}, std::int64_t{1}, std::numeric_limits<std::int64_t>::max()}) {
    Bench bench;
    for (std::uint64_t i = 0; i < 300; ++i) {
      ForceSegment s = constant_segment(bench.now, push);
      s.trust_time = {trust};
      bench.send(s, {bench.now + ms * 59'000, bench.now, i});
      bench.tick();
    }
    for (int i = 0; i < 199; ++i) bench.tick();
    BOOST_TEST(!is_zero(bench.commanded));
    bench.tick();
    BOOST_TEST(is_zero(bench.commanded));
  }
}

BOOST_AUTO_TEST_CASE(a_segment_that_was_made_long_ago_is_not_fresh_when_it_is_found) {
  Bench bench;
  const Time made = bench.now;
  bench.tick();
  // The process was stopped for a second.
  bench.now = bench.now + Duration{1'000'000'000};
  bench.send(constant_segment(made, push), {made, made, 1});
  for (int i = 0; i < 300; ++i) {
    bench.tick();
    BOOST_REQUIRE(is_zero(bench.commanded));
  }
  bench.feed(push, 150);
  BOOST_TEST((bench.commanded.force == push.force));
}

BOOST_AUTO_TEST_CASE(a_device_that_has_shown_nothing_yet_gets_no_force) {
  Bench bench;
  bench.device().answer = ReadResult::not_yet;
  bench.feed(push, 50);
  BOOST_TEST(is_zero(bench.commanded));
  BOOST_TEST(!bench.state.has_value());
  BOOST_TEST((bench.safety.cause == SafetyCause::device_not_ready));
  bench.device().answer = ReadResult::sample;
  bench.feed(push, 150);
  BOOST_TEST((bench.commanded.force == push.force));
  // After the first sample its silence is a failure.
  bench.device().answer = ReadResult::not_yet;
  bench.feed(push, 3);
  BOOST_TEST(is_zero(bench.commanded));
  BOOST_TEST((bench.safety.cause == SafetyCause::read_failed));
}

BOOST_AUTO_TEST_CASE(a_state_that_is_not_finite_is_not_sent_and_counts_as_a_failed_read) {
  Bench bench;
  bench.feed(push, 150);
  bench.device().shown.state.X_WD.R.w = std::numeric_limits<double>::quiet_NaN();
  bench.feed(push, 3);
  BOOST_TEST(!bench.state.has_value());
  BOOST_TEST(is_zero(bench.commanded));
  BOOST_TEST(bench.metrics().at("device.causes.read_failed") == 1.0);
}

BOOST_AUTO_TEST_CASE(a_device_that_fails_for_long_ends_the_run_after_zero_was_commanded) {
  for (const bool reading : {true, false}) {
    Bench bench({{"failure_timeout", 0.05}});
    bench.feed(push, 150);
    ScriptedDevice& device = bench.device();
    if (reading) {
      device.answer = ReadResult::failed;
    } else {
      device.takes = false;
    }
    for (int i = 0; i < 50; ++i) BOOST_REQUIRE_NO_THROW(bench.tick());
    BOOST_TEST(is_zero(bench.commanded));
    const int writes = device.writes;
    StepContext context(bench.now);
    BOOST_CHECK_EXCEPTION(device.step(context), RunError, [reading](const RunError& error) {
      const std::string text = error.what();
      return text.find("device arm could not be " + std::string(reading ? "read" : "written")) == 0 &&
             text.find("the plug is out; its parameter failure_timeout (0.05") != std::string::npos;
    });
    BOOST_TEST(device.writes == writes + 1);
    if (reading) BOOST_TEST(is_zero(device.taken));
  }
}

BOOST_AUTO_TEST_CASE(a_device_that_comes_back_in_time_goes_on) {
  Bench bench({{"failure_timeout", 0.05}, {"recovery_time", 0.02}});
  bench.feed(push, 150);
  for (int i = 0; i < 5; ++i) {
    bench.device().answer = ReadResult::failed;
    bench.feed(push, 45);
    bench.device().answer = ReadResult::sample;
    bench.feed(push, 10);
  }
  bench.feed(push, 150);
  BOOST_TEST((bench.commanded.force == push.force));
  BOOST_TEST(bench.metrics().at("device.causes.read_failed") == 5.0);
}

BOOST_AUTO_TEST_CASE(while_stopping_it_asks_for_steps_until_zero_is_commanded) {
  Bench bench;
  bench.phase = Phase::starting;
  bench.feed(push, 50);
  BOOST_TEST(is_zero(bench.commanded));
  bench.phase = Phase::running;
  bench.feed(push, 150);
  bench.phase = Phase::stopping;
  for (int i = 0; i < 100; ++i) {
    BOOST_TEST(!bench.tick());
    BOOST_TEST(norm(bench.device().taken.force - (1 - ramp(i / 100.0)) * push.force) < 1e-13);
  }
  BOOST_TEST(bench.tick());
  BOOST_TEST(is_zero(bench.device().taken));
}

BOOST_AUTO_TEST_CASE(the_dead_man_button_is_the_one_that_was_named) {
  Bench bench({{"dead_man_button", std::int64_t{3}}});
  bench.device().shown.state.buttons = 0b1011;
  bench.feed(push, 150);
  BOOST_TEST(is_zero(bench.commanded));
  bench.device().shown.state.buttons = 0b0100;
  bench.feed(push, 150);
  BOOST_TEST((bench.commanded.force == push.force));
  bench.device().shown.state.buttons = 0;
  bench.feed(push, 101);
  BOOST_TEST(is_zero(bench.commanded));
  BOOST_TEST(bench.metrics().at("device.causes.dead_man") == 2.0);
}

BOOST_AUTO_TEST_CASE(a_translation_only_scene_gets_no_torque_and_no_limit_on_turning) {
  Bench bench({}, false);
  bench.device().shown.state.V_WD.w = {500, 0, 0};
  bench.feed(push, 150);
  BOOST_TEST((bench.commanded.force == push.force));
  BOOST_TEST((bench.commanded.torque == Vec3{}));
  BOOST_TEST((bench.interpolated.value().torque == Vec3{}));
}

BOOST_AUTO_TEST_CASE(a_segment_that_is_not_finite_is_rejected_and_counted) {
  Bench bench;
  bench.feed(push, 150);
  bench.feed({{std::numeric_limits<double>::quiet_NaN(), 0, 0}, {}}, 4);
  BOOST_TEST(is_zero(bench.commanded));
  BOOST_TEST(bench.metrics().at("device.rejected_forces") == 4.0);
  BOOST_TEST(bench.metrics().at("device.causes.not_finite") == 1.0);
}

BOOST_AUTO_TEST_CASE(a_step_allocates_nothing) {
  Bench bench({{"recovery_time", 0.02}});
  ScriptedDevice& device = bench.device();
  ForceSegment s;
  std::int64_t most = 0;
  for (std::uint64_t i = 0; i < 3000; ++i) {
    // Engagement, staleness, NaN, failures and overspeed all come by.
    s = constant_segment(bench.now, i % 700 == 350 ? Wrench{{std::nan(""), 0, 0}, {}} : push);
    if (i % 900 < 500) device.segment.push({bench.now, bench.now, i}, &s);
    device.answer = i % 800 == 790 ? ReadResult::failed : ReadResult::sample;
    device.shown.state.V_WD.v.x = i % 1100 == 1090 ? 5 : 0;
    StepContext context(bench.now, i < 10 ? Phase::starting : Phase::running);
    const std::int64_t before = thread_heap_calls();
    device.step(context);
    most = std::max(most, thread_heap_calls() - before);
    device.state.clear_pending();
    device.interpolated.clear_pending();
    device.commanded.clear_pending();
    device.safety.clear_pending();
    bench.now = bench.now + ms;
  }
  BOOST_TEST((thread_heap_calls() > 0) == heap_calls_are_counted());
  BOOST_TEST(most == 0);
  BOOST_TEST(bench.metrics().at("device.faults") > 2.0);
  BOOST_TEST(bench.metrics().at("device.stale") > 1.0);
}

BOOST_AUTO_TEST_CASE(after_the_device_has_let_go_the_force_starts_from_zero) {
  Bench bench;
  bench.feed(push, 300);
  BOOST_TEST(bench.commanded.force.y == 4.0);
  bench.now = bench.now + ms * 9;
  bench.device().shown.expired = true;
  bench.feed(push, 1);
  BOOST_TEST(std::abs(bench.commanded.force.y - 4) < 1e-12);  // two periods of 2 N, from zero
  bench.feed(push, 1);
  BOOST_TEST(std::abs(bench.commanded.force.y - 2) < 1e-12);
  bench.device().shown.expired = false;
  bench.feed(push, 1);
  BOOST_TEST(bench.commanded.force.y == 4.0);
  BOOST_TEST(bench.metrics().at("device.causes.expired") == 1);
  // Told with a reading that failed, too.
  bench.device().shown.expired = true;
  bench.device().answer = ReadResult::failed;
  bench.feed(push, 1);
  BOOST_TEST(is_zero(bench.commanded));
}

BOOST_AUTO_TEST_SUITE_END()
