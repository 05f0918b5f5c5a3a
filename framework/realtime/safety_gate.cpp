#include "framework/realtime/safety_gate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <sstream>
#include <string>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

constexpr std::array<std::string_view, safety_cause_count> cause_names{
    "none",  "not_finite",    "overspeed",  "read_failed",      "write_failed", "time_reversed",     "dead_man",
    "stale", "not_permitted", "no_segment", "device_not_ready", "time_gap",     "outside_workspace", "expired"};

constexpr std::uint32_t bit(SafetyCause cause) {
  return std::uint32_t{1} << static_cast<unsigned>(cause);
}

constexpr std::uint32_t fault_causes = bit(SafetyCause::not_finite) | bit(SafetyCause::overspeed) |
                                       bit(SafetyCause::read_failed) | bit(SafetyCause::write_failed) |
                                       bit(SafetyCause::time_reversed);
constexpr std::uint32_t passing_causes = bit(SafetyCause::time_gap) | bit(SafetyCause::expired);

/// The most serious of several causes: the first in the order of the enumeration.
SafetyCause first_of(std::uint32_t causes) {
  for (int i = 1; i < safety_cause_count; ++i) {
    const auto cause = static_cast<SafetyCause>(i);
    if ((causes & bit(cause)) != 0) return cause;
  }
  return SafetyCause::none;
}

/// 3 x^2 - 2 x^3 for x in [0, 1]: no slope at the ends, the steepest is `steepest`.
double smooth(double x) {
  x = std::clamp(x, 0.0, 1.0);
  return x * x * (3.0 - 2.0 * x);
}
constexpr double steepest = 1.5;

double share(Duration part, Duration whole) {
  return whole.ns <= 0 ? 1.0 : static_cast<double>(part.ns) / static_cast<double>(whole.ns);
}

/// Sums of durations stay within an hour, which is longer than every time that is compared with them.
constexpr Duration longest_sum{3'600'000'000'000};
Duration sum(Duration a, Duration b) {
  return std::min(a + b, longest_sum);
}

struct Clamped {
  Vec3 value;
  bool shortened = false;
};

/// `a` (finite) shortened to `most`; the largest component is divided out first, so that no square overflows.
Clamped clamped(const Vec3& a, double most) {
  const double scale = std::max({std::abs(a.x), std::abs(a.y), std::abs(a.z)});
  if (scale == 0) return {};
  const Vec3 unit{a.x / scale, a.y / scale, a.z / scale};
  const double length = norm(unit);
  if (length <= most / scale) return {a, false};
  return {(most / length) * unit, true};
}

Vec3 moved_towards(const Vec3& target, const Vec3& from, double most) {
  const Vec3 change = target - from;
  const double length = norm(change);
  // The slack is rounding: without it a ramp that just fits would end a breath above zero.
  if (length <= most * (1.0 + 1e-12)) return target;
  return from + (most / length) * change;
}

Vec3 brake(const Vec3& velocity, double speed_max, double most) {
  return (-most / std::max(norm(velocity), speed_max)) * velocity;
}

std::string text(double value) {
  std::ostringstream out;
  out << value;
  return out.str();
}

void check_positive(const std::string& name, const std::string& unit, double value, bool zero_allowed) {
  if (std::isfinite(value) && (value > 0 || (zero_allowed && value == 0))) return;
  throw InputError(name + ": expected a finite value " + (zero_allowed ? "of at least" : "above") + " 0, found " +
                   text(value) + " " + unit);
}

void check_time(const std::string& name, Duration value, bool zero_allowed) {
  check_positive(name, "s", value.seconds(), zero_allowed);
  if (value < longest_sum) return;
  throw InputError(name + ": expected less than an hour, found " + text(value.seconds()) + " s");
}

/// The release of `most` over the ramp-down time is steepest in its middle; the slew limit must not hold it up.
void check_slew(const std::string& name, const std::string& unit, double most, double slew, Duration ramp_down_time) {
  const double least = steepest * most / ramp_down_time.seconds();
  // A limit that was copied from this message has six digits; the ramp is flat at its end, so that it catches up.
  if (slew >= (1.0 - 1e-5) * least) return;
  throw InputError(name + "_slew: expected at least " + text(least) + " " + unit + "/s, so that " + name + "_max (" +
                   text(most) + " " + unit + ") can go to zero within ramp_down_time (" +
                   text(ramp_down_time.seconds()) + " s), found " + text(slew) + " " + unit + "/s; raise " + name +
                   "_slew or ramp_down_time, or lower " + name + "_max");
}

}  // namespace

std::string_view name_of(SafetyCause cause) {
  return cause_names[static_cast<std::size_t>(cause)];
}

std::string_view name_of(Engagement engagement) {
  constexpr std::array<std::string_view, 4> names{"disengaged", "ramping", "engaged", "fault"};
  return names[static_cast<std::size_t>(engagement)];
}

void check(const SafetyLimits& limits) {
  check_positive("force_max", "N", limits.force_max, true);
  check_positive("torque_max", "N m", limits.torque_max, true);
  check_positive("force_slew", "N/s", limits.force_slew, false);
  check_positive("torque_slew", "N m/s", limits.torque_slew, false);
  check_positive("speed_max", "m/s", limits.speed_max, false);
  check_positive("angular_speed_max", "rad/s", limits.angular_speed_max, false);
  check_time("engage_time", limits.engage_time, false);
  check_time("stale_after", limits.stale_after, false);
  check_time("ramp_down_time", limits.ramp_down_time, false);
  check_time("brake_time", limits.brake_time, true);
  check_time("recovery_time", limits.recovery_time, true);
  check_slew("force", "N", limits.force_max, limits.force_slew, limits.ramp_down_time);
  check_slew("torque", "N m", limits.torque_max, limits.torque_slew, limits.ramp_down_time);
}

SafetyGate::SafetyGate(const SafetyLimits& limits, Duration period) : limits_(limits), clock_(Duration{2 * period.ns}) {
  TACTOR_DEMAND(period.ns > 0);
  check(limits);
}

void SafetyGate::set_largest(double force_max, double torque_max) noexcept {
  limits_.force_max = force_max;
  limits_.torque_max = torque_max;
}

bool SafetyGate::at_rest() const {
  return commanded_D_W_.force == Vec3{} && commanded_D_W_.torque == Vec3{};
}

SafetyGate::Interval SafetyGate::TickClock::advance(Time now) {
  std::int64_t ns = 0;
  if (started_ && __builtin_sub_overflow(now.ns, last_.ns, &ns)) {
    ns = now < last_ ? -1 : std::numeric_limits<std::int64_t>::max();
  }
  const Duration elapsed{std::clamp<std::int64_t>(ns, 0, longest_sum.ns)};
  const bool gap = started_ && (ns == 0 || ns > longest_.ns);
  started_ = true;
  last_ = now;
  return {elapsed, std::min(elapsed, longest_), ns < 0, gap};
}

void SafetyGate::SegmentAge::advance(const SafetyInput& input, Duration elapsed, Duration stale_after) {
  age_ = input.fresh_segment ? Duration{} : sum(age_, elapsed);
  if (input.fresh_segment) stale_at_ = std::clamp(input.fresh_for, Duration{}, stale_after);
  any_ = any_ || input.fresh_segment;
}

SafetyGate::Causes SafetyGate::causes_of(const SafetyInput& input, const Interval& interval) const {
  Causes causes = 0;
  const auto add_if = [&causes](bool active, SafetyCause cause) {
    if (active) causes |= bit(cause);
  };
  const bool moves_finitely = is_finite(input.V_WD.v) && is_finite(input.V_WD.w);
  add_if(input.wanted_D_W && !is_finite(*input.wanted_D_W), SafetyCause::not_finite);
  add_if(input.health == DeviceHealth::read_failed || !moves_finitely, SafetyCause::read_failed);
  add_if(input.health == DeviceHealth::write_failed, SafetyCause::write_failed);
  add_if(input.health == DeviceHealth::not_ready, SafetyCause::device_not_ready);
  add_if(moves_finitely && (norm(input.V_WD.v) > limits_.speed_max || norm(input.V_WD.w) > limits_.angular_speed_max),
         SafetyCause::overspeed);
  add_if(interval.reversed, SafetyCause::time_reversed);
  add_if(interval.gap, SafetyCause::time_gap);
  add_if(!input.dead_man_held, SafetyCause::dead_man);
  add_if(!input.in_workspace, SafetyCause::outside_workspace);
  add_if(input.expired, SafetyCause::expired);
  add_if(!input.permitted, SafetyCause::not_permitted);
  const bool none_yet = !segment_.any() || !input.wanted_D_W;
  add_if(none_yet, SafetyCause::no_segment);
  add_if(segment_.is_stale(), SafetyCause::stale);
  return causes;
}

void SafetyGate::count_new(Causes causes) {
  const Causes fresh = causes & ~causes_;
  causes_ = causes;
  for (int i = 1; i < safety_cause_count; ++i) {
    if ((fresh & bit(static_cast<SafetyCause>(i))) != 0) ++account_.begun[static_cast<std::size_t>(i)];
  }
}

void SafetyGate::enter(Mode mode, SafetyCause cause) {
  const bool was_fault = mode_ == Mode::fault || mode_ == Mode::braking;
  if (!was_fault && (mode == Mode::fault || mode == Mode::braking)) ++account_.faults;
  mode_ = mode;
  cause_ = cause;
  in_mode_ = {};
}

bool SafetyGate::may_brake(Causes causes, const Twist& V_WD) const {
  const Causes other = causes & ~(bit(SafetyCause::overspeed) | passing_causes);
  const bool fast = norm(V_WD.v) > 0.5 * limits_.speed_max || norm(V_WD.w) > 0.5 * limits_.angular_speed_max;
  return other == 0 && fast && limits_.brake_time.ns > 0;
}

void SafetyGate::change_mode(Causes causes, const Twist& V_WD) {
  const Causes faulty = causes & fault_causes;
  const Causes serious = causes & ~passing_causes;
  if (mode_ == Mode::braking) {
    if (in_mode_ >= limits_.brake_time || !may_brake(causes, V_WD)) enter(Mode::fault, cause_);
    return;
  }
  if (mode_ == Mode::fault) {
    if (faulty != 0) cause_ = first_of(faulty);
    if (healthy_for_ < limits_.recovery_time || faulty != 0 || !at_rest()) return;
    enter(Mode::disengaged, SafetyCause::none);
  }
  if (faulty != 0) {
    const bool pushes = mode_ != Mode::disengaged;
    enter(pushes && may_brake(causes, V_WD) ? Mode::braking : Mode::fault, first_of(faulty));
    return;
  }
  if (mode_ == Mode::releasing && in_mode_ >= limits_.ramp_down_time && at_rest()) {
    enter(Mode::disengaged, SafetyCause::none);
  }
  if (mode_ == Mode::disengaged) {
    cause_ = first_of(serious);
    if (serious == 0) enter(Mode::engaging, SafetyCause::none);
    return;
  }
  if (mode_ == Mode::releasing) return;
  if (serious != 0) {
    released_D_W_ = commanded_D_W_;
    released_gain_ = gain_;
    enter(Mode::releasing, first_of(serious));
    // Staleness began between two ticks, and its time to zero counts from there.
    if ((serious & bit(SafetyCause::stale)) != 0) in_mode_ = segment_.stale_for();
  } else if (mode_ == Mode::engaging && in_mode_ >= limits_.engage_time) {
    enter(Mode::engaged, SafetyCause::none);
  }
}

Wrench SafetyGate::target_for(const Wrench& clamped_D_W, const Twist& V_WD) {
  switch (mode_) {
    case Mode::engaging:
      gain_ = smooth(share(in_mode_, limits_.engage_time));
      return gain_ * clamped_D_W;
    case Mode::engaged:
      gain_ = 1;
      return clamped_D_W;
    case Mode::releasing: {
      if (in_mode_ >= limits_.ramp_down_time) break;
      const double left = 1.0 - smooth(share(in_mode_, limits_.ramp_down_time));
      gain_ = left * released_gain_;
      return left * released_D_W_;
    }
    case Mode::braking:
      gain_ = 0;
      return {brake(V_WD.v, limits_.speed_max, limits_.force_max),
              brake(V_WD.w, limits_.angular_speed_max, limits_.torque_max)};
    case Mode::disengaged:
    case Mode::fault:
      break;
  }
  gain_ = 0;
  return {};
}

Wrench SafetyGate::slewed(const Wrench& target, Duration elapsed) const {
  const double dt = elapsed.seconds();
  return {moved_towards(target.force, commanded_D_W_.force, limits_.force_slew * dt),
          moved_towards(target.torque, commanded_D_W_.torque, limits_.torque_slew * dt)};
}

/// With what is commanded by now.
void SafetyGate::keep_account(const SafetyInput& input, Causes causes, const Wrench& clamped_D_W) {
  ++account_.ticks;
  for (int i = 1; i < safety_cause_count; ++i) {
    if ((causes & bit(static_cast<SafetyCause>(i))) != 0) ++account_.present[static_cast<std::size_t>(i)];
  }
  const bool brakes = mode_ == Mode::braking || mode_ == Mode::fault;
  if (!at_rest()) ++(brakes ? account_.braked : account_.forced);
  const bool wanted = input.wanted_D_W && !(input.wanted_D_W->force == Vec3{} && input.wanted_D_W->torque == Vec3{});
  if (!wanted) return;
  ++account_.wanted;
  if (is_finite(*input.wanted_D_W) && clamped_D_W.force == Vec3{} && clamped_D_W.torque == Vec3{}) ++account_.no_room;
  if (!at_rest() && !brakes) return;
  const SafetyCause why = brakes ? cause_ : first_of(causes & ~passing_causes);
  ++account_.withheld[static_cast<std::size_t>(why)];
}

Wrench SafetyGate::within_limits(const std::optional<Wrench>& wanted_D_W) {
  if (!wanted_D_W) return {};
  if (!is_finite(*wanted_D_W)) {
    ++account_.rejected;
    return {};
  }
  const Clamped force = clamped(wanted_D_W->force, limits_.force_max);
  const Clamped torque = clamped(wanted_D_W->torque, limits_.torque_max);
  if (force.shortened || torque.shortened) ++account_.clamped;
  return {force.value, torque.value};
}

SafetyOutput SafetyGate::tick(const SafetyInput& input) noexcept {
  if (input.expired) commanded_D_W_ = released_D_W_ = {};
  const Interval interval = clock_.advance(input.now);
  segment_.advance(input, interval.elapsed, limits_.stale_after);
  // A ramp that comes in takes no leap over a gap in time; one that goes out may, for the slew limit follows it.
  in_mode_ = sum(in_mode_, mode_ == Mode::engaging ? interval.slew_elapsed : interval.elapsed);
  const Causes causes = causes_of(input, interval);
  count_new(causes);
  healthy_for_ = (causes & fault_causes) != 0 ? Duration{} : sum(healthy_for_, interval.elapsed);

  const Wrench clamped_D_W = within_limits(input.wanted_D_W);
  change_mode(causes, input.V_WD);
  const Wrench target = target_for(clamped_D_W, input.V_WD);
  commanded_D_W_ = slewed(target, interval.slew_elapsed);
  if (!(commanded_D_W_.force == target.force && commanded_D_W_.torque == target.torque)) ++account_.slewed;
  keep_account(input, causes, clamped_D_W);
  if (mode_ == Mode::engaged) ++account_.engaged;

  Engagement engagement = Engagement::disengaged;
  switch (mode_) {
    case Mode::disengaged:
      break;
    case Mode::engaging:
    case Mode::releasing:
      engagement = Engagement::ramping;
      break;
    case Mode::engaged:
      engagement = Engagement::engaged;
      break;
    case Mode::braking:
    case Mode::fault:
      engagement = Engagement::fault;
      break;
  }
  return {commanded_D_W_, {engagement, cause_, gain_, clamped_D_W}};
}

}  // namespace tactor
