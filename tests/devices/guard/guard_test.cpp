// The guard's slots, what it refuses, its ramp, and its gate by axis, against closed forms and an independent
// integration. Mutations that must fail here: no sum in SlotReader::take fails
// `a_record_with_any_bit_turned_is_not_used`; no ramp in CommandChannel::letting_go fails
// `an_expired_command_goes_to_zero_linearly`; a deadline of ten times fails that one too.
#include <array>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <cstring>
#include <memory>
#include <thread>

#include "devices/guard/engine_slots.hpp"
#include "devices/hardware/axis_gate.hpp"
#include "devices/hardware/guard_share.hpp"

using namespace tactor;

namespace {

constexpr std::int64_t ms = 1'000'000;
constexpr std::int64_t us = 1'000;

AxisLimits one_motor() {
  AxisLimits limits;
  limits.axes = 1;
  limits.effort_max[0] = 10;
  limits.speed_max[0] = 1;
  limits.jump_tolerance[0] = 1e-3;
  limits.q_min[0] = -0.1;
  limits.q_max[0] = 0.1;
  return limits;
}

CommandTiming guard_timing() {
  return {.age_max = Duration{50 * ms}, .expires_after = Duration{2 * ms}, .let_go = Duration{3 * ms}};
}

AxisValues effort(double value) {
  AxisValues values{};
  values[0] = value;
  return values;
}

/// An engine that gives orders, and the line in the guard, at times that the test sets.
struct Guarded {
  std::unique_ptr<GuardShare> share = std::make_unique<GuardShare>();
  SlotWriter<GuardOrder> engine{share->orders};
  SlotReader<LinkReport> reports{share->reports};
  EngineSlots slots{*share, guard_timing().expires_after};
  LineCycle cycle{"rig", one_motor(), guard_timing(), LineEnergyOptions{.axes = 1}, {&slots, &share->board, {}}};
  // The clock of the machine, because the slots ask it whether an order is of the future.
  Instant now = MonotonicClock::now() - Duration{1'000 * ms};
  Instant zeroed = now;
  std::uint64_t epoch = 0;

  Guarded() {
    LinkFailure failure;
    BOOST_TEST_REQUIRE(cycle.opened({}, failure));
    LinkReport report;
    BOOST_TEST_REQUIRE((reports.take(report) == SlotFound::value));
    epoch = report.cuts;
    // The line was opened just now; the engine commands zero after that.
    now = MonotonicClock::now() + Duration{1};
    while (MonotonicClock::now() <= now) continue;
    order(0);
    given();
  }
  GuardOrder made(double force) {
    if (force == 0) zeroed = now;
    return {.command = {effort(force), {}, Duration{4 * ms}},
            .produced = now,
            .deadline = now + guard_timing().expires_after,
            .zeroed = zeroed,
            .epoch = epoch};
  }
  void order(double force) { engine.put(made(force)); }
  double given(Duration later = {}) { return cycle.due(now + later).effort[0]; }
};

}  // namespace

BOOST_AUTO_TEST_SUITE(guard_test)

BOOST_AUTO_TEST_CASE(a_record_with_any_bit_turned_is_not_used) {
  auto slot = std::make_unique<SharedSlot<GuardOrder>>();
  SlotWriter<GuardOrder> writer(*slot);
  SlotReader<GuardOrder> reader(*slot);
  GuardOrder order, found;
  BOOST_TEST((reader.take(found) == SlotFound::nothing));
  for (std::size_t bit = 0; bit < 8 * sizeof(GuardOrder); ++bit) {
    order.epoch = bit;
    writer.put(order);
    auto& record = slot->places[slot->between.load() & slot->number];
    record.value[bit / 8] ^= std::byte{1} << (bit % 8);
    BOOST_TEST_REQUIRE((reader.take(found) == SlotFound::damaged));
    writer.put(order);
    BOOST_TEST_REQUIRE((reader.take(found) == SlotFound::value));
    BOOST_TEST_REQUIRE(found.epoch == bit);
  }
}

BOOST_AUTO_TEST_CASE(an_older_record_and_a_place_that_does_not_exist_are_not_used) {
  auto slot = std::make_unique<SharedSlot<GuardOrder>>();
  SlotWriter<GuardOrder> writer(*slot);
  SlotReader<GuardOrder> reader(*slot);
  GuardOrder order, found;
  order.epoch = 1;
  writer.put(order);
  const auto old = slot->places[slot->between.load() & slot->number];
  BOOST_TEST((reader.take(found) == SlotFound::value));
  order.epoch = 2;
  writer.put(order);
  BOOST_TEST((reader.take(found) == SlotFound::value));
  writer.put(order);
  slot->places[slot->between.load() & slot->number] = old;  // whole, and of before
  BOOST_TEST((reader.take(found) == SlotFound::damaged));
  BOOST_TEST(found.epoch == 2U);
  slot->between = slot->number | slot->unread;
  BOOST_TEST((reader.take(found) == SlotFound::damaged));
  // Both go on.
  for (int i = 0; i < 6; ++i) {
    writer.put(order);
    static_cast<void>(reader.take(found));
  }
  order.epoch = 3;
  writer.put(order);
  BOOST_TEST((reader.take(found) == SlotFound::value));
  BOOST_TEST(found.epoch == 3U);
}

BOOST_AUTO_TEST_CASE(two_threads_never_see_half_a_record) {
  auto slot = std::make_unique<SharedSlot<std::array<std::uint64_t, 64>>>();
  constexpr std::uint64_t last = 100'000;
  std::thread writing([&] {
    SlotWriter<std::array<std::uint64_t, 64>> writer(*slot);
    for (std::uint64_t i = 1; i <= last; ++i) {
      std::array<std::uint64_t, 64> value;
      value.fill(i);
      writer.put(value);
    }
  });
  SlotReader<std::array<std::uint64_t, 64>> reader(*slot);
  std::array<std::uint64_t, 64> value{};
  std::uint64_t newest = 0, damaged = 0, mixed = 0;
  while (newest < last) {
    const SlotFound found = reader.take(value);
    damaged += found == SlotFound::damaged ? 1 : 0;
    if (found != SlotFound::value) continue;
    for (const std::uint64_t one : value) mixed += one != value[0] ? 1 : 0;
    mixed += value[0] <= newest ? 1 : 0;
    newest = value[0];
  }
  writing.join();
  BOOST_TEST(damaged == 0U);
  BOOST_TEST(mixed == 0U);
}

BOOST_AUTO_TEST_CASE(an_expired_command_goes_to_zero_linearly) {
  for (const double force : {0.01, 8.0, -8.0}) {
    Guarded line;
    line.now = line.now + Duration{1};
    line.order(force);
    for (std::int64_t at = 0; at <= 8'000; at += 250) {
      const double late = static_cast<double>(at) / 1e3 - 2;  // ms
      const double share = late <= 0 ? 1 : std::max(0.0, 1 - late / 3);
      BOOST_TEST(std::abs(line.given(Duration{at * us}) - force * share) < 1e-9);
    }
    // Zero that was given may not have come to the device.
    BOOST_TEST(!line.slots.at_rest());
    line.cycle.failed({LinkError::timeout, "no answer"});
    BOOST_TEST(!line.slots.at_rest());
    BOOST_TEST(line.given(Duration{9'000 * us}) == 0);
    line.cycle.took(line.now, {}, "");
    BOOST_TEST(line.slots.at_rest());
  }
}

BOOST_AUTO_TEST_CASE(orders_of_another_epoch_of_the_future_and_of_too_long_are_refused) {
  Guarded line;
  const auto refused = [&](const GuardOrder& order) {
    const std::uint64_t before = line.slots.refused();
    line.engine.put(order);
    return line.given() == 0 && line.slots.refused() == before + 1;
  };
  GuardOrder order = line.made(5);
  order.epoch = line.epoch - 1;
  BOOST_TEST(refused(order));
  order.epoch = line.epoch + 1;
  BOOST_TEST(refused(order));
  order = line.made(5);
  order.produced = MonotonicClock::now() + Duration{60'000 * ms};
  order.deadline = order.produced + Duration{2 * ms};
  BOOST_TEST(refused(order));
  order = line.made(5);
  order.deadline = order.deadline + Duration{1};
  BOOST_TEST(refused(order));
  order = line.made(5);
  order.zeroed = order.produced + Duration{1};
  BOOST_TEST(refused(order));
  line.order(5);
  BOOST_TEST(line.given() == 5);
}

BOOST_AUTO_TEST_CASE(an_engine_that_was_stopped_is_obeyed_again_only_when_it_has_seen_the_cut_and_commanded_zero) {
  Guarded line;
  line.order(5);
  BOOST_TEST(line.given() == 5);
  BOOST_TEST(line.given(Duration{60 * ms}) == 0);
  LinkReport report;
  while (line.reports.take(report) == SlotFound::value) continue;
  BOOST_TEST_REQUIRE(report.cuts == line.epoch + 1);
  // It goes on with what it knew, at a time of its own.
  line.now = line.now + Duration{61 * ms};
  while (MonotonicClock::now() <= line.now) continue;
  line.order(5);
  BOOST_TEST(line.given() == 0);
  line.epoch = report.cuts;
  line.order(5);
  BOOST_TEST(line.given() == 0);
  line.order(0);
  line.given();
  line.now = line.now + Duration{1};
  line.order(5);
  BOOST_TEST(line.given() == 5);
}

BOOST_AUTO_TEST_CASE(a_guard_that_is_to_end_takes_the_force_to_zero) {
  Guarded line;
  line.order(5);
  BOOST_TEST(line.given() == 5);
  BOOST_TEST(!line.slots.at_rest());
  line.slots.refuse_all();
  line.now = line.now + Duration{1 * ms};
  line.order(5);
  BOOST_TEST(line.given(Duration{5 * ms}) == 0);
  BOOST_TEST(!line.slots.at_rest());
  line.cycle.took(line.now, {}, "");
  BOOST_TEST(line.slots.at_rest());
}

BOOST_AUTO_TEST_CASE(the_heat_of_a_winding_is_that_of_an_rc_circuit) {
  constexpr double continuous = 4, time = 30, force = 9;
  WindingHeat heat(continuous, time);
  double by_euler = 0;
  constexpr int steps = 100'000;
  constexpr double dt = 10.0 / steps;
  for (int i = 0; i < steps; ++i) {
    heat.add(force, dt);
    by_euler += dt / time * (force * force / (continuous * continuous) - by_euler);
  }
  const double closed = force * force / (continuous * continuous) * (1 - std::exp(-10 / time));
  BOOST_TEST(std::abs(heat.share() - closed) < 1e-9);
  BOOST_TEST(std::abs(by_euler - closed) < 1e-3);
  WindingHeat unknown;
  unknown.add(1e6, 1e6);
  BOOST_TEST(unknown.most(10) == 10);
}

BOOST_AUTO_TEST_CASE(a_motor_at_its_largest_effort_comes_down_to_the_continuous_one_and_never_gets_too_warm) {
  AxisGateLimits limits;
  limits.continuous[0] = 4;
  limits.thermal_time[0] = 5;
  AxisGate gate(limits);
  const AxisLimits axes = one_motor();
  Instant now{1};
  double last = 10, most = 0;
  for (int i = 0; i < 60'000; ++i) {
    const AxisValues given = gate.give(now, effort(10), axes);
    gate.gave(now, given);
    BOOST_TEST_REQUIRE(given[0] <= last + 1e-9);
    last = given[0];
    most = std::max(most, gate.heat(0).share());
    now = now + Duration{ms};
  }
  BOOST_TEST(most <= 1);
  BOOST_TEST(std::abs(last - 4) < 0.05);
}

BOOST_AUTO_TEST_CASE(an_effort_grows_by_its_slew_limit_turns_round_by_way_of_zero_and_goes_down_at_once) {
  AxisGateLimits limits;
  limits.slew[0] = 1000;  // 1 N a cycle
  AxisGate gate(limits);
  const AxisLimits axes = one_motor();
  Instant now{1};
  const auto pass = [&](double wanted) {
    const AxisValues given = gate.give(now, effort(wanted), axes);
    gate.gave(now, given);
    now = now + Duration{ms};
    return given[0];
  };
  BOOST_TEST(pass(0) == 0);
  for (const double expected : {1.0, 2.0, 3.0, 4.0, 5.0, 5.0}) BOOST_TEST(std::abs(pass(5) - expected) < 1e-9);
  BOOST_TEST(std::abs(pass(-5) + 1) < 1e-9);
  BOOST_TEST(std::abs(pass(-5) + 2) < 1e-9);
  BOOST_TEST(pass(-0.5) == -0.5);
}

BOOST_AUTO_TEST_CASE(beyond_the_fence_and_beyond_the_speed_it_lets_go_until_zero_was_commanded) {
  const AxisLimits axes = one_motor();
  for (const GateHold why : {GateHold::outside, GateHold::speed}) {
    AxisGateLimits limits;
    limits.speed = why == GateHold::speed;
    limits.patience = Duration{20 * ms};
    AxisGate gate(limits);
    Instant now{1};
    double q = 0;
    const auto pass = [&](double wanted, double speed) {
      q += speed * 1e-3;
      gate.see(now, effort(q), axes);
      const AxisValues given = gate.give(now, effort(wanted), axes);
      gate.gave(now, given);
      now = now + Duration{ms};
      return given[0];
    };
    for (int i = 0; i < 50; ++i) BOOST_TEST(pass(5, 0.5) == 5);
    if (why == GateHold::outside) {
      q = 0.2;
      for (int i = 0; i < 20; ++i) BOOST_TEST(pass(5, 0) == 5);
    } else {
      for (int i = 0; i < 9; ++i) pass(5, 3);
    }
    double given = 5;
    for (int i = 0; i < 16 && gate.hold() == GateHold::none; ++i) given = pass(5, limits.speed ? 3 : 0);
    BOOST_TEST((gate.hold() == why));
    for (int i = 0; i < 4; ++i) {
      const double next = pass(5, 0);
      BOOST_TEST(next <= given);
      given = next;
    }
    BOOST_TEST(given == 0);
    // The reason goes; the force stays away until the loop has commanded zero.
    q = 0;
    for (int i = 0; i < 40; ++i) BOOST_TEST(pass(5, 0) == 0);
    pass(0, 0);
    BOOST_TEST((gate.hold() == GateHold::none));
    BOOST_TEST(pass(5, 0) == 5);
  }
}

BOOST_AUTO_TEST_CASE(a_configuration_comes_back_as_it_was_and_a_cut_one_is_refused) {
  GuardConfig config;
  config.layout = guard_layout;
  config.line = "modbus";
  config.limits = one_motor();
  config.gate.slew[3] = 12;
  config.energy.lever[7] = 0.5;
  config.expires_after = Duration{3 * ms};
  const std::string bytes = to_bytes(config);
  const auto back = from_bytes<GuardConfig>(bytes);
  BOOST_TEST(to_bytes(back) == bytes);
  BOOST_TEST(back.gate.slew[3] == 12);
  BOOST_TEST(back.energy.lever[7] == 0.5);
  for (std::size_t size = 0; size < bytes.size(); size += 7) {
    BOOST_CHECK_THROW(from_bytes<GuardConfig>({bytes.data(), size}), RunError);
  }
}

BOOST_AUTO_TEST_SUITE_END()
