// Every rule of the safety gate against closed forms, and its promises under any input.
#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "framework/core/check.hpp"
#include "tests/framework/realtime/gate_drive.hpp"

BOOST_AUTO_TEST_SUITE(safety_gate_test)

using namespace tactor;
using tactor::test::Drive;
using tactor::test::ramp;
using tactor::test::tick_period;

namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double infinite = std::numeric_limits<double>::infinity();
const Wrench push{{3, -4, 0}, {0, 0.12, 0.16}};  // 5 N, 0.2 N m

bool is_zero(const Wrench& w) {
  return w.force == Vec3{} && w.torque == Vec3{};
}

std::string refusal(const SafetyLimits& limits) {
  try {
    check(limits);
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_wrench_comes_in_along_the_ramp) {
  SafetyLimits limits;
  limits.engage_time = Duration{40'000'000};
  Drive drive(limits);
  drive.input.wanted_D_W = push;
  for (int i = 0; i <= 60; ++i) {
    const SafetyOutput& out = drive.tick();
    const double gain = ramp(i / 40.0);
    BOOST_TEST(std::abs(out.safety.gain - gain) < 1e-15);
    BOOST_TEST(norm(out.commanded_D_W.force - gain * push.force) < 1e-14);
    BOOST_TEST(norm(out.commanded_D_W.torque - gain * push.torque) < 1e-15);
    BOOST_TEST(out.safety.engagement == (i < 40 ? Engagement::ramping : Engagement::engaged));
    BOOST_TEST(out.safety.cause == SafetyCause::none);
  }
  BOOST_TEST(drive.gate.account().engaged == 21U);
  BOOST_TEST(drive.gate.account().slewed == 0U);
}

BOOST_AUTO_TEST_CASE(a_wrench_beyond_the_limits_is_shortened_along_its_direction) {
  Drive drive(SafetyLimits{});
  drive.engage({});
  for (const double size : {5.0, 8.0, 9.0, 1e3, 1e160, 1.7e308}) {
    const Vec3 along{0.6 * size, -0.8 * size, 0};
    drive.input.wanted_D_W = Wrench{along, along};
    drive.ticks(20);
    const double expected = std::min(size, 8.0), expected_torque = std::min(size, 0.3);
    BOOST_TEST(norm(drive.output.commanded_D_W.force - expected * Vec3{0.6, -0.8, 0}) < 1e-12);
    BOOST_TEST(norm(drive.output.commanded_D_W.torque - expected_torque * Vec3{0.6, -0.8, 0}) < 1e-12);
    BOOST_TEST(norm(drive.output.safety.clamped_D_W.force - drive.output.commanded_D_W.force) < 1e-12);
  }
  // The six sizes in N m are all beyond the limit of the torque.
  BOOST_TEST(drive.gate.account().clamped == 120U);
}

BOOST_AUTO_TEST_CASE(a_step_is_slewed_by_norm_and_arrives_exactly) {
  SafetyLimits limits;
  limits.force_slew = 500;  // half a newton in a tick
  limits.torque_slew = 20;
  Drive drive(limits);
  drive.engage({{5, 0, 0}, {}});
  drive.input.wanted_D_W = Wrench{{5, 3, 4}, {0, 0.2, 0}};  // 5 N away: ten ticks
  for (int i = 1; i <= 12; ++i) {
    drive.tick();
    const double way = std::min(i * 0.5, 5.0);
    BOOST_TEST(norm(drive.output.commanded_D_W.force - Vec3{5, 0.6 * way, 0.8 * way}) < 1e-12);
    BOOST_TEST(std::abs(drive.output.commanded_D_W.torque.y - std::min(i * 0.02, 0.2)) < 1e-15);
  }
  BOOST_TEST((drive.output.commanded_D_W.force == Vec3{5, 3, 4}));
  BOOST_TEST(drive.gate.account().slewed == 9U);
}

BOOST_AUTO_TEST_CASE(a_force_without_fresh_segments_ends_at_the_stated_time_along_the_ramp) {
  SafetyLimits limits;
  limits.stale_after = Duration{30'500'000};  // between two ticks
  limits.ramp_down_time = Duration{50'000'000};
  Drive drive(limits);
  drive.engage(push);
  drive.input.fresh_segment = false;
  for (int age = 1; age <= 120; ++age) {
    // The pipeline may say what it wants by then.
    if (age > 31) drive.input.wanted_D_W = Wrench{{0, 0, age % 2 == 0 ? 8.0 : -8.0}, {}};
    drive.tick();
    const double left = 1 - ramp((age - 30.5) / 50);
    BOOST_TEST(norm(drive.output.commanded_D_W.force - left * push.force) < 1e-13);
    BOOST_TEST(norm(drive.output.commanded_D_W.torque - left * push.torque) < 1e-14);
    BOOST_TEST(is_zero(drive.output.commanded_D_W) == (age >= 81));
    if (age > 30) BOOST_TEST(drive.output.safety.cause == SafetyCause::stale);
    BOOST_TEST(drive.output.safety.engagement == (age <= 30   ? Engagement::engaged
                                                  : age <= 81 ? Engagement::ramping
                                                              : Engagement::disengaged));
  }
  BOOST_TEST(drive.gate.count(SafetyCause::stale) == 1U);
  BOOST_TEST(drive.gate.account().faults == 0U);

  drive.input.fresh_segment = true;
  drive.input.wanted_D_W = push;
  for (int i = 0; i <= 100; ++i) {
    drive.tick();
    BOOST_TEST(norm(drive.output.commanded_D_W.force - ramp(i / 100.0) * push.force) < 1e-13);
  }
  BOOST_TEST(drive.output.safety.engagement == Engagement::engaged);
}

BOOST_AUTO_TEST_CASE(nothing_is_commanded_without_permission_a_segment_or_a_device_that_is_ready) {
  for (int missing = 0; missing < 4; ++missing) {
    Drive drive(SafetyLimits{});
    drive.input.wanted_D_W = push;
    if (missing == 0) drive.input.permitted = false;
    if (missing == 1) drive.input.fresh_segment = false;
    if (missing == 2) drive.input.health = DeviceHealth::not_ready;
    if (missing == 3) drive.input.dead_man_held = false;
    for (int i = 0; i < 300; ++i) {
      drive.tick();
      BOOST_TEST(is_zero(drive.output.commanded_D_W));
      BOOST_TEST(drive.output.safety.engagement == Engagement::disengaged);
    }
    const SafetyCause expected[] = {SafetyCause::not_permitted, SafetyCause::no_segment, SafetyCause::device_not_ready,
                                    SafetyCause::dead_man};
    BOOST_TEST(drive.output.safety.cause == expected[missing]);
    BOOST_TEST(drive.gate.count(expected[missing]) == 1U);
  }
}

BOOST_AUTO_TEST_CASE(the_end_of_permission_and_a_released_dead_man_ramp_to_zero) {
  for (const bool dead_man : {false, true}) {
    Drive drive(SafetyLimits{});
    drive.engage(push);
    (dead_man ? drive.input.dead_man_held : drive.input.permitted) = false;
    for (int i = 0; i < 150; ++i) {
      drive.tick();
      BOOST_TEST(norm(drive.output.commanded_D_W.force - (1 - ramp(i / 100.0)) * push.force) < 1e-13);
      BOOST_TEST(std::abs(drive.output.safety.gain - (1 - ramp(i / 100.0))) < 1e-15);
      BOOST_TEST(is_zero(drive.output.commanded_D_W) == (i >= 100));
      BOOST_TEST(drive.output.safety.cause == (dead_man ? SafetyCause::dead_man : SafetyCause::not_permitted));
    }
    BOOST_TEST(drive.gate.at_rest());
  }
}

BOOST_AUTO_TEST_CASE(a_release_that_has_begun_goes_down_before_the_gate_engages_anew) {
  Drive drive(SafetyLimits{});
  drive.engage(push);
  drive.input.dead_man_held = false;
  drive.ticks(10);
  drive.input.dead_man_held = true;
  for (int i = 10; i <= 100; ++i) {
    drive.tick();
    BOOST_TEST(norm(drive.output.commanded_D_W.force - (1 - ramp(i / 100.0)) * push.force) < 1e-13);
  }
  for (int i = 0; i <= 100; ++i) {
    drive.tick();
    BOOST_TEST(norm(drive.output.commanded_D_W.force - ramp(i / 100.0) * push.force) < 1e-13);
  }
}

BOOST_AUTO_TEST_CASE(what_is_not_finite_is_a_fault_that_lasts_until_inputs_have_been_healthy) {
  for (const double bad : {not_a_number, infinite, -infinite}) {
    SafetyLimits limits;
    limits.recovery_time = Duration{200'000'000};
    Drive drive(limits);
    drive.engage(push);
    drive.input.wanted_D_W = Wrench{{0, 0, 0}, {0, bad, 0}};
    for (int i = 1; i <= 5; ++i) {
      drive.tick();
      // 5 N at 2 N a tick.
      BOOST_TEST(std::abs(norm(drive.output.commanded_D_W.force) - std::max(5.0 - 2 * i, 0.0)) < 1e-12);
      BOOST_TEST(drive.output.safety.engagement == Engagement::fault);
      BOOST_TEST(drive.output.safety.cause == SafetyCause::not_finite);
      BOOST_TEST(is_zero(drive.output.safety.clamped_D_W));
    }
    BOOST_TEST(drive.gate.account().rejected == 5U);
    drive.input.wanted_D_W = push;
    for (int i = 1; i < 200; ++i) {
      drive.tick();
      BOOST_TEST(drive.output.safety.engagement == Engagement::fault);
      BOOST_TEST(is_zero(drive.output.commanded_D_W));
    }
    for (int i = 0; i <= 100; ++i) {
      drive.tick();
      BOOST_TEST(norm(drive.output.commanded_D_W.force - ramp(i / 100.0) * push.force) < 1e-13);
    }
    BOOST_TEST(drive.gate.account().faults == 1U);
    BOOST_TEST(drive.gate.count(SafetyCause::not_finite) == 1U);
  }
}

BOOST_AUTO_TEST_CASE(a_device_that_cannot_be_read_or_written_is_a_fault) {
  const std::pair<DeviceHealth, SafetyCause> cases[] = {{DeviceHealth::read_failed, SafetyCause::read_failed},
                                                        {DeviceHealth::write_failed, SafetyCause::write_failed},
                                                        {DeviceHealth::ok, SafetyCause::read_failed}};
  for (const auto& [health, cause] : cases) {
    Drive drive(SafetyLimits{});
    drive.engage(push);
    drive.input.health = health;
    if (health == DeviceHealth::ok) drive.input.V_WD.v.z = not_a_number;  // a device that shows nonsense
    drive.ticks(6);
    BOOST_TEST(is_zero(drive.output.commanded_D_W));
    BOOST_TEST(drive.output.safety.engagement == Engagement::fault);
    BOOST_TEST(drive.output.safety.cause == cause);
    BOOST_TEST(drive.gate.count(cause) == 1U);
  }
}

BOOST_AUTO_TEST_CASE(a_handle_that_is_too_fast_is_braked_against_its_motion_and_then_let_go) {
  SafetyLimits limits;
  limits.brake_time = Duration{30'000'000};
  Drive drive(limits);
  drive.engage(push);
  drive.input.V_WD = {{0, 0, 4}, {0, -33, 0}};
  drive.ticks(10);  // 5 N and 8 N apart: at 2 N a tick the brake is reached by now
  BOOST_TEST(norm(drive.output.commanded_D_W.force - Vec3{0, 0, -8}) < 1e-12);
  BOOST_TEST(norm(drive.output.commanded_D_W.torque - Vec3{0, 0.3, 0}) < 1e-12);
  BOOST_TEST(drive.output.safety.engagement == Engagement::fault);
  BOOST_TEST(drive.output.safety.cause == SafetyCause::overspeed);
  // Below the limits it is a damper of force_max / speed_max.
  drive.input.V_WD = {{1.5, 0, 0}, {0, 0, 24}};
  drive.ticks(10);
  BOOST_TEST(norm(drive.output.commanded_D_W.force - Vec3{-1.5 * 8 / 2, 0, 0}) < 1e-12);
  BOOST_TEST(norm(drive.output.commanded_D_W.torque - Vec3{0, 0, -24 * 0.3 / 30}) < 1e-12);
  drive.ticks(10);
  BOOST_TEST(!is_zero(drive.output.commanded_D_W));
  drive.ticks(9);  // 30 ms are over, and then the slew
  BOOST_TEST(is_zero(drive.output.commanded_D_W));
  BOOST_TEST(drive.output.safety.engagement == Engagement::fault);
  BOOST_TEST(drive.gate.count(SafetyCause::overspeed) == 1U);
  BOOST_TEST(drive.gate.account().faults == 1U);
}

BOOST_AUTO_TEST_CASE(a_brake_ends_at_half_the_speed_limit) {
  Drive drive(SafetyLimits{});
  drive.engage({});
  drive.input.V_WD.v = {2.5, 0, 0};
  drive.ticks(10);
  BOOST_TEST(std::abs(drive.output.commanded_D_W.force.x + 8) < 1e-12);
  drive.input.V_WD.v = {0.99, 0, 0};
  drive.ticks(4);
  BOOST_TEST(is_zero(drive.output.commanded_D_W));
}

BOOST_AUTO_TEST_CASE(a_brake_takes_energy_from_the_handle_and_never_gives_any) {
  // A handle of 0.2 kg, thrown at 3 m/s from an engaged gate at zero force, and brakes as long as they like.
  SafetyLimits limits;
  limits.brake_time = Duration{10'000'000'000};
  Drive drive(limits);
  drive.engage({});
  const double mass = 0.2;
  Vec3 v{1.8, -2.4, 0};
  double energy = 0.5 * mass * dot(v, v);
  for (int i = 0; i < 2000; ++i) {
    drive.input.V_WD.v = v;
    drive.tick();
    BOOST_TEST(dot(drive.output.commanded_D_W.force, v) <= 0);
    v += (tick_period.seconds() / mass) * drive.output.commanded_D_W.force;
    const double next = 0.5 * mass * dot(v, v);
    BOOST_TEST(next <= energy);
    energy = next;
  }
  BOOST_TEST(norm(v) < 1.0);
  BOOST_TEST(norm(v) > 0.5);  // it has been let go at half the limit
}

BOOST_AUTO_TEST_CASE(a_free_handle_that_is_too_fast_is_not_braked) {
  Drive drive(SafetyLimits{});
  drive.input.wanted_D_W = push;
  drive.input.V_WD.v = {5, 0, 0};
  for (int i = 0; i < 100; ++i) BOOST_TEST(is_zero(drive.tick().commanded_D_W));
  BOOST_TEST(drive.output.safety.engagement == Engagement::fault);
}

BOOST_AUTO_TEST_CASE(time_that_stands_still_holds_the_force_and_time_set_back_is_a_fault) {
  Drive drive(SafetyLimits{});
  drive.engage(push);
  drive.input.wanted_D_W = Wrench{{-8, 0, 0}, {}};
  const Time now = drive.input.now - tick_period;
  for (int i = 0; i < 10; ++i) {
    drive.input.now = now;
    drive.tick();
    BOOST_TEST((drive.output.commanded_D_W.force == push.force));
  }
  BOOST_TEST(drive.gate.count(SafetyCause::time_gap) == 1U);
  drive.input.now = now - Duration{5'000'000'000};
  drive.tick();
  BOOST_TEST((drive.output.commanded_D_W.force == push.force));
  BOOST_TEST(drive.output.safety.engagement == Engagement::fault);
  BOOST_TEST(drive.output.safety.cause == SafetyCause::time_reversed);
  drive.ticks(6);
  BOOST_TEST(is_zero(drive.output.commanded_D_W));
}

BOOST_AUTO_TEST_CASE(a_clock_set_back_makes_no_segment_young) {
  SafetyLimits limits;
  limits.recovery_time = Duration{0};
  Drive drive(limits);
  drive.engage(push);
  drive.input.fresh_segment = false;
  drive.input.now = drive.input.now - Duration{5'000'000'000};
  drive.ticks(201);
  BOOST_TEST(is_zero(drive.output.commanded_D_W));
  BOOST_TEST(drive.output.safety.cause == SafetyCause::stale);
}

BOOST_AUTO_TEST_CASE(a_gap_in_time_counts_as_two_periods_for_the_slew_limit) {
  Drive drive(SafetyLimits{});
  drive.engage({{8, 0, 0}, {}});
  drive.input.wanted_D_W = Wrench{{-8, 0, 0}, {}};
  drive.input.now = drive.input.now + Duration{90'000'000};
  drive.tick();
  BOOST_TEST(std::abs(drive.output.commanded_D_W.force.x - 4) < 1e-12);  // 2000 N/s for 2 ms
  BOOST_TEST(drive.output.safety.engagement == Engagement::engaged);
  BOOST_TEST(drive.gate.count(SafetyCause::time_gap) == 1U);
  // A gap without a fresh segment is staleness as well.
  drive.input.fresh_segment = false;
  drive.input.now = drive.input.now + Duration{1'000'000'000};
  drive.tick();
  BOOST_TEST(drive.output.safety.cause == SafetyCause::stale);
  BOOST_TEST(std::abs(drive.output.commanded_D_W.force.x) < 1e-12);
}

BOOST_AUTO_TEST_CASE(a_gap_in_time_hurries_a_ramp_down_and_no_ramp_up) {
  SafetyLimits limits;
  limits.force_slew = 1e6;
  Drive drive(limits);
  drive.input.wanted_D_W = push;
  drive.ticks(31);
  drive.input.now = drive.input.now + Duration{60'000'000};
  drive.tick();
  BOOST_TEST(norm(drive.output.commanded_D_W.force - ramp(0.32) * push.force) < 1e-13);
  drive.engage(push);
  drive.input.dead_man_held = false;
  drive.ticks(11);
  drive.input.now = drive.input.now + Duration{60'000'000};
  drive.tick();
  BOOST_TEST(norm(drive.output.commanded_D_W.force - (1 - ramp(0.71)) * push.force) < 1e-13);
}

BOOST_AUTO_TEST_CASE(limits_that_cannot_be_are_refused_with_the_mend) {
  BOOST_TEST(refusal(SafetyLimits{}).empty());
  SafetyLimits limits;
  limits.force_slew = 100;  // 1.5 * 8 N / 0.1 s = 120 N/s
  BOOST_TEST(refusal(limits) ==
             "force_slew: expected at least 120 N/s, so that force_max (8 N) can go to zero within ramp_down_time (0.1 "
             "s), found 100 N/s; raise force_slew or ramp_down_time, or lower force_max");
  limits.force_slew = 120;
  BOOST_TEST(refusal(limits).empty());
  limits = {};
  limits.torque_slew = 4.4;
  BOOST_TEST(refusal(limits).find("torque_slew: expected at least 4.5 N m/s") == 0U);
  limits = {};
  limits.ramp_down_time = Duration{0};
  BOOST_TEST(refusal(limits).find("ramp_down_time: expected a finite value above 0, found 0 s") == 0U);
  limits = {};
  limits.force_max = not_a_number;
  BOOST_TEST(refusal(limits).find("force_max: expected") == 0U);
  limits = {};
  limits.speed_max = 0;
  BOOST_TEST(refusal(limits).find("speed_max: expected") == 0U);
  limits = {};
  limits.stale_after = Duration{4'000'000'000'000};
  BOOST_TEST(refusal(limits).find("stale_after: expected less than an hour") == 0U);
  BOOST_CHECK_THROW(SafetyGate(limits, tick_period), InputError);
}

BOOST_AUTO_TEST_CASE(every_cause_has_a_name_of_its_own) {
  for (int i = 0; i < safety_cause_count; ++i) {
    BOOST_TEST(!name_of(static_cast<SafetyCause>(i)).empty());
    for (int k = 0; k < i; ++k)
      BOOST_TEST(name_of(static_cast<SafetyCause>(i)) != name_of(static_cast<SafetyCause>(k)));
  }
  BOOST_TEST(name_of(SafetyCause::time_gap) == "time_gap");
  BOOST_TEST(name_of(SafetyCause::stale) == "stale");
  BOOST_TEST(name_of(SafetyCause::overspeed) == "overspeed");
}

namespace {

/// Inputs as bad as they come, in stretches: each stretch draws what is wrong in it.
class Adversary {
 public:
  explicit Adversary(std::uint64_t seed) : engine_(seed) {}

  double uniform(double a, double b) { return std::uniform_real_distribution<double>(a, b)(engine_); }
  bool one_in(int n) { return std::uniform_int_distribution<int>(1, n)(engine_) == 1; }
  std::int64_t whole(std::int64_t a, std::int64_t b) {
    return std::uniform_int_distribution<std::int64_t>(a, b)(engine_);
  }

  SafetyLimits limits() {
    SafetyLimits l;
    l.force_max = one_in(20) ? 0 : std::pow(10.0, uniform(-2, 2));
    l.torque_max = one_in(20) ? 0 : std::pow(10.0, uniform(-3, 1));
    l.engage_time = {whole(1'000'000, 300'000'000)};
    l.stale_after = {whole(1'000'000, 200'000'000)};
    l.ramp_down_time = {whole(1'000'000, 200'000'000)};
    l.brake_time = {one_in(5) ? 0 : whole(1, 300'000'000)};
    l.recovery_time = {one_in(5) ? 0 : whole(1, 300'000'000)};
    l.speed_max = uniform(0.1, 3);
    l.angular_speed_max = uniform(1, 50);
    // From just enough on: the tight case is the one that could miss the stated time.
    const double least = 1.5 / l.ramp_down_time.seconds();
    l.force_slew = std::max(least * l.force_max * (one_in(3) ? 1.0 : std::pow(10.0, uniform(0, 3))), 1e-3);
    l.torque_slew = std::max(least * l.torque_max * (one_in(3) ? 1.0 : std::pow(10.0, uniform(0, 3))), 1e-3);
    return l;
  }

  void new_stretch() {
    left_ = static_cast<int>(whole(1, 600));
    calm_ = one_in(3);
    fresh_every_ = one_in(3) ? 1'000'000 : static_cast<int>(whole(1, 30));
    time_trouble_ = !calm_ && one_in(4);
    force_trouble_ = !calm_ && one_in(4);
    flicker_ = !calm_ && one_in(4);
    device_trouble_ = !calm_ && one_in(4);
    short_trust_ = !calm_ && one_in(4);
    fast_ = !calm_ && one_in(4);
    permitted_ = !one_in(6);
    held_ = !one_in(8);
    constant_ = vector(10);
  }

  SafetyInput next(Duration period) {
    if (left_-- <= 0) new_stretch();
    SafetyInput in;
    std::int64_t dt = period.ns;
    if (time_trouble_ && one_in(10)) {
      const std::int64_t kinds[] = {0, -period.ns, -5'000'000'000, 30'000'000, 20'000'000'000, whole(0, 5'000'000)};
      dt = kinds[whole(0, 5)];
      if (one_in(400)) now_ = {one_in(2) ? std::numeric_limits<std::int64_t>::max() : -1'000'000'000'000};
    }
    if (__builtin_add_overflow(now_.ns, dt, &now_.ns)) now_.ns = std::numeric_limits<std::int64_t>::min();
    in.now = now_;
    in.fresh_segment = one_in(fresh_every_);
    if (short_trust_) in.fresh_for = {one_in(40) ? whole(-1'000'000'000, -1) : whole(0, 250'000'000)};
    if (!one_in(2000)) in.wanted_D_W = Wrench{one_in(3) ? vector(10) : constant_, one_in(3) ? vector(1) : constant_};
    if (force_trouble_ && one_in(5) && in.wanted_D_W) {
      const double kinds[] = {not_a_number, infinite, -infinite, 1e308, -1.7e308, 1e-320};
      in.wanted_D_W->force[static_cast<int>(whole(0, 2))] = kinds[whole(0, 5)];
      in.wanted_D_W->torque[static_cast<int>(whole(0, 2))] = kinds[whole(0, 5)];
    }
    in.V_WD = {vector(fast_ ? 4 : 0.1), vector(fast_ ? 60 : 1)};
    if (fast_ && one_in(200)) in.V_WD.v.x = one_in(2) ? not_a_number : 1e300;
    if (device_trouble_ && one_in(20)) in.health = static_cast<DeviceHealth>(whole(0, 3));
    in.permitted = flicker_ ? one_in(2) : permitted_;
    in.dead_man_held = flicker_ ? !one_in(4) : held_;
    return in;
  }

 private:
  Vec3 vector(double size) { return {uniform(-size, size), uniform(-size, size), uniform(-size, size)}; }

  std::mt19937_64 engine_;
  int left_ = 0;
  bool calm_ = true, short_trust_ = false, time_trouble_ = false, force_trouble_ = false, flicker_ = false,
       device_trouble_ = false;
  bool fast_ = false, permitted_ = true, held_ = true;
  int fresh_every_ = 1;
  Vec3 constant_;
  Time now_;
};

}  // namespace

BOOST_AUTO_TEST_CASE(whatever_comes_in_the_promises_are_kept) {
  constexpr int sequences = 500, length = 4000;  // two million ticks
  std::uint64_t engaged = 0, faults = 0, stale = 0, braked = 0;
  for (int s = 0; s < sequences; ++s) {
    Adversary adversary(static_cast<std::uint64_t>(s) + 1);
    const SafetyLimits limits = adversary.limits();
    const Duration period{adversary.whole(100'000, 4'000'000)};
    SafetyGate gate(limits, period);
    const std::int64_t longest = gate.longest_tick().ns;
    Wrench before;
    Time last;
    bool any_fresh = false;
    std::int64_t since_fresh = 0, without_permission = 0;  // ns, a tick counts as at most the longest
    Duration stale_at;
    bool ever_permitted = false;
    for (int i = 0; i < length; ++i) {
      const SafetyInput in = adversary.next(period);
      // In extended precision, so that this side of the check does not wrap around.
      const auto passed = static_cast<long double>(in.now.ns) - static_cast<long double>(last.ns);
      const std::int64_t dt =
          i == 0 || passed < 0 ? 0 : static_cast<std::int64_t>(std::min<long double>(passed, longest));
      last = in.now;
      since_fresh = in.fresh_segment ? 0 : since_fresh + dt;
      any_fresh = any_fresh || in.fresh_segment;
      if (in.fresh_segment) stale_at = std::max(Duration{}, std::min(in.fresh_for, limits.stale_after));
      without_permission = in.permitted ? 0 : without_permission + dt;
      ever_permitted = ever_permitted || in.permitted;

      const SafetyOutput out = gate.tick(in);
      const Wrench& now = out.commanded_D_W;
      const std::string where = "sequence " + std::to_string(s) + ", tick " + std::to_string(i);
      BOOST_REQUIRE_MESSAGE(is_finite(now), where);
      BOOST_REQUIRE_MESSAGE(norm(now.force) <= limits.force_max * (1 + 1e-12), where);
      BOOST_REQUIRE_MESSAGE(norm(now.torque) <= limits.torque_max * (1 + 1e-12), where);
      const double seconds = static_cast<double>(dt) * 1e-9;
      // The sum of a step and what was there is rounded to a last digit of the largest value.
      const double rounding = 1e-15 * limits.force_max, rounding_torque = 1e-15 * limits.torque_max;
      BOOST_REQUIRE_MESSAGE(norm(now.force - before.force) <= limits.force_slew * seconds * (1 + 1e-9) + rounding,
                            where);
      BOOST_REQUIRE_MESSAGE(
          norm(now.torque - before.torque) <= limits.torque_slew * seconds * (1 + 1e-9) + rounding_torque, where);
      const std::int64_t outlived = stale_at.ns + limits.ramp_down_time.ns;
      if (!any_fresh || since_fresh >= outlived) BOOST_REQUIRE_MESSAGE(is_zero(now), where);
      // Permission can have ended anywhere before its first tick without it, hence one tick more.
      if (!ever_permitted || without_permission >= limits.ramp_down_time.ns + longest) {
        BOOST_REQUIRE_MESSAGE(is_zero(now), where);
      }
      if (out.safety.engagement == Engagement::disengaged) BOOST_REQUIRE_MESSAGE(is_zero(now), where);
      BOOST_REQUIRE_MESSAGE(out.safety.gain >= 0 && out.safety.gain <= 1, where);
      BOOST_REQUIRE_MESSAGE(is_finite(out.safety.clamped_D_W), where);
      if (out.safety.cause == SafetyCause::overspeed && !is_zero(now)) ++braked;
      before = now;
    }
    engaged += gate.account().engaged;
    faults += gate.account().faults;
    stale += gate.count(SafetyCause::stale);
  }
  // The inputs were not so bad that nothing ever happened.
  BOOST_TEST(engaged > 100'000U);
  BOOST_TEST(faults > 1'000U);
  BOOST_TEST(stale > 1'000U);
  BOOST_TEST(braked > 1'000U);
}

BOOST_AUTO_TEST_CASE(the_time_to_zero_holds_on_the_clock_where_ticks_come_in_time) {
  // Every phase of the last fresh segment against the tick, with the slew limit as low as it may be.
  for (int period_us = 100; period_us <= 3000; period_us += 170) {
    SafetyLimits limits;
    limits.force_slew = 120;
    limits.torque_slew = 4.5;
    const Duration period{period_us * 1000};
    SafetyGate gate(limits, period);
    SafetyInput in;
    in.permitted = true;
    Time fresh;
    for (int i = 0; i < 4'000'000 / period_us; ++i) {
      in.now = Time{i * period.ns};
      in.fresh_segment = i * period_us <= 1'000'000;
      if (in.fresh_segment) fresh = in.now;
      in.wanted_D_W = Wrench{{0, 8, 0}, {0.3, 0, 0}};
      const SafetyOutput out = gate.tick(in);
      if (in.now - fresh >= Duration{200'000'000}) BOOST_REQUIRE(is_zero(out.commanded_D_W));
    }
    BOOST_TEST(gate.account().engaged > 0U);
  }
}

BOOST_AUTO_TEST_CASE(lower_limits_are_reached_as_fast_as_the_slew_limits_let_it) {
  SafetyLimits limits;
  limits.force_slew = 500;
  limits.torque_slew = 10;
  Drive drive(limits);
  drive.engage(push);  // 5 N, 0.2 N m
  drive.gate.set_largest(1, 0.05);
  for (int i = 1; i <= 20; ++i) {
    const SafetyOutput& out = drive.tick();
    BOOST_TEST(std::abs(norm(out.commanded_D_W.force) - std::max(1.0, 5 - 0.5 * i)) < 1e-12);
    BOOST_TEST(std::abs(norm(out.commanded_D_W.torque) - std::max(0.05, 0.2 - 0.01 * i)) < 1e-12);
  }
  drive.gate.set_largest(8, 0.3);
  for (int i = 1; i <= 20; ++i) {
    BOOST_TEST(std::abs(norm(drive.tick().commanded_D_W.force) - std::min(5.0, 1 + 0.5 * i)) < 1e-12);
  }
}

BOOST_AUTO_TEST_SUITE_END()
