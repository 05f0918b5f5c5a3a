// The safety gate between a pipeline and an actuator: what it wants goes through within limits, or comes down to zero.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>

#include "framework/core/messages.hpp"
#include "framework/core/time.hpp"
#include "framework/realtime/force_account.hpp"

namespace tactor {

/// The limits of a safety gate. Vectors are limited by norm.
struct SafetyLimits {
  double force_max = 8;           ///< N
  double torque_max = 0.3;        ///< N m
  double force_slew = 2000;       ///< N/s, largest change of the commanded force
  double torque_slew = 40;        ///< N m/s
  double speed_max = 2;           ///< m/s
  double angular_speed_max = 30;  ///< rad/s
  Duration engage_time{100'000'000};
  Duration stale_after{100'000'000};     ///< without a fresh segment, at most
  Duration ramp_down_time{100'000'000};  ///< from what is commanded to zero
  Duration brake_time{50'000'000};       ///< the longest brake
  Duration recovery_time{500'000'000};   ///< of healthy inputs, after which a fault ends
};

/// Throws InputError where a limit cannot be (negative, zero, not finite), or where a slew limit is too low for the
/// largest wrench to go to zero within the ramp_down_time.
void check(const SafetyLimits& limits);

/// How the device answered.
enum class DeviceHealth : std::uint8_t { ok, not_ready, read_failed, write_failed };

/// What a gate sees at one tick.
struct SafetyInput {
  static constexpr Duration longest{std::numeric_limits<std::int64_t>::max()};
  Time now;
  std::optional<Wrench> wanted_D_W;  ///< what the pipeline wants; absent: nothing yet
  bool fresh_segment = false;        ///< a fresh segment has come since the last tick
  Duration fresh_for = longest;      ///< how long that one stays fresh, where that is less than stale_after
  Twist V_WD;                        ///< of the device, m/s and rad/s
  DeviceHealth health = DeviceHealth::ok;
  bool dead_man_held = true;
  bool in_workspace = true;  ///< of the device
  bool expired = false;      ///< since the last tick the device has let go of what was commanded
  bool permitted = false;    ///< the run lets devices engage
};

/// What a gate lets through.
struct SafetyOutput {
  Wrench commanded_D_W;
  SafetyState safety;
};

/// The name of a cause or a state, as metrics and texts spell it.
std::string_view name_of(SafetyCause cause);
std::string_view name_of(Engagement engagement);

/// Called once a tick. Allocates nothing, locks nothing, throws nothing.
///
/// Whatever comes in, what goes out is finite, within force_max and torque_max, and changes from tick to tick by at
/// most force_slew and torque_slew times the time between them, which counts as zero where it is negative and as
/// `longest_tick` where it is more. The slew limit comes last, so that it holds on the way to zero as well.
///
/// Time to zero: exactly zero from the first tick on that is stale_after + ramp_down_time or more after the last fresh
/// segment, or fresh_for + ramp_down_time where its fresh_for is less than stale_after (below zero counts as zero),
/// where ticks come within longest_tick of one another; a longer gap counts as one longest_tick. A release
/// (dead-man, run stopping) takes ramp_down_time, a fault force_max / force_slew, which `check` keeps below it.
///
/// With p(x) = 3 x^2 - 2 x^3:
/// - engaging: p(t / engage_time) times the wanted wrench within the limits;
/// - releasing (dead-man, outside the workspace, stale, the run stopping): 1 - p(t / ramp_down_time) times what was
/// commanded when it began, whatever the pipeline does;
/// - braking: -force_max v / max(|v|, speed_max), torque alike, against the motion; it ends when brake_time is over,
///   when the device is down to half its speed limits, or when anything else is wrong. The wrench before the slew limit
///   never gives power to the device; what is commanded goes straight from what it was towards it;
/// - fault: zero.
/// A release that has begun goes down to zero before the gate engages anew. Where a command has expired, zero is taken
/// for what was commanded: the wrench comes back from there by the slew limit, and a release stays at zero.
class SafetyGate {
 public:
  /// `period` is that of the ticks, above zero. Throws InputError as `check` does.
  SafetyGate(const SafetyLimits& limits, Duration period);

  SafetyOutput tick(const SafetyInput& input) noexcept;
  /// Other limits of what is commanded, N and N m, which `check` takes with the rest. What is commanded comes down to
  /// lower ones as fast as the slew limits let it. Allocates nothing.
  void set_largest(double force_max, double torque_max) noexcept;

  /// Two periods.
  [[nodiscard]] Duration longest_tick() const { return clock_.longest(); }
  [[nodiscard]] const Wrench& commanded() const { return commanded_D_W_; }
  /// Of the ramp, 0 to 1.
  [[nodiscard]] double gain() const { return gain_; }
  /// True where exactly zero is commanded.
  [[nodiscard]] bool at_rest() const;
  /// How often a cause has come up.
  [[nodiscard]] std::uint64_t count(SafetyCause cause) const { return account_.begun[static_cast<std::size_t>(cause)]; }
  [[nodiscard]] const GateAccount& account() const { return account_; }

 private:
  enum class Mode : std::uint8_t { disengaged, engaging, engaged, releasing, braking, fault };
  using Causes = std::uint32_t;  // one bit a cause

  /// The time between two ticks.
  struct Interval {
    Duration elapsed;       // at least zero
    Duration slew_elapsed;  // the same, at most longest_tick
    bool reversed = false;
    bool gap = false;
  };
  class TickClock {
   public:
    explicit TickClock(Duration longest) : longest_(longest) {}
    [[nodiscard]] Duration longest() const { return longest_; }
    /// The time from the last call to this one.
    Interval advance(Time now);

   private:
    Duration longest_;
    bool started_ = false;
    Time last_;
  };

  /// The age of the newest fresh segment, summed up from ticks, so that a clock set back makes no segment young.
  class SegmentAge {
   public:
    void advance(const SafetyInput& input, Duration elapsed, Duration stale_after);
    [[nodiscard]] bool any() const { return any_; }
    [[nodiscard]] bool is_stale() const { return any_ && age_ >= stale_at_; }
    [[nodiscard]] Duration stale_for() const { return age_ - stale_at_; }

   private:
    Duration age_;
    Duration stale_at_;  // the age from which on it is stale
    bool any_ = false;
  };

  [[nodiscard]] Causes causes_of(const SafetyInput& input, const Interval& interval) const;
  void count_new(Causes causes);
  [[nodiscard]] Wrench within_limits(const std::optional<Wrench>& wanted_D_W);
  void change_mode(Causes causes, const Twist& V_WD);
  [[nodiscard]] bool may_brake(Causes causes, const Twist& V_WD) const;
  [[nodiscard]] Wrench target_for(const Wrench& clamped_D_W, const Twist& V_WD);
  [[nodiscard]] Wrench slewed(const Wrench& target, Duration elapsed) const;
  void enter(Mode mode, SafetyCause cause);
  void keep_account(const SafetyInput& input, Causes causes, const Wrench& clamped_D_W);

  SafetyLimits limits_;
  TickClock clock_;
  SegmentAge segment_;

  Mode mode_ = Mode::disengaged;
  SafetyCause cause_ = SafetyCause::none;
  Duration in_mode_;      // time since the mode was entered
  Duration healthy_for_;  // without a cause of a fault
  Causes causes_ = 0;     // of the last tick

  Wrench commanded_D_W_;
  double gain_ = 0;           // of the ramp
  Wrench released_D_W_;       // commanded when the release began
  double released_gain_ = 0;  // when the release began

  GateAccount account_;
};

}  // namespace tactor
