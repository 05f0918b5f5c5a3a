// The last gate before the motors, axis by axis: what no command gets past, whoever made it.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "devices/hardware/axis_limits.hpp"
#include "framework/core/bytes.hpp"
#include "framework/realtime/monotonic_clock.hpp"

namespace tactor {

/// What an AxisGate lets through. By default it lets everything through.
struct AxisGateLimits {
  AxisValues slew = every_axis(LinkLimits::unknown);  ///< N/s or N m/s by which an effort may grow
  AxisValues continuous{};                            ///< N or N m that the motor bears for ever; 0: not known
  AxisValues thermal_time{};                          ///< s, of the motor's winding; 0: not known
  Duration patience{200'000'000};  ///< so long an effort may act outside the workspace; then the gate holds it back
  Duration let_go{3'000'000};      ///< from an effort that is held back to zero
  bool speed = false;              ///< whether a handle beyond its largest speed is let go
};
void fields(auto& bytes, SameAs<AxisGateLimits> auto& l) {
  bytes(l.slew, l.continuous, l.thermal_time, l.patience, l.let_go, l.speed);
}

/// Why a gate holds the efforts back.
enum class GateHold : std::uint8_t {
  none,
  outside,  ///< the handle is outside the workspace, and the efforts went on
  speed,    ///< the handle is faster than any hand
};
/// What it says to a user: `its handle is faster than its axes can be moved`.
const char* words_of(GateHold hold);

/// Temperature of a motor's winding, as a share of the largest one: dT/dt = ((F / F_continuous)^2 - T) / time, from 0
/// on. At F_continuous it goes to 1, at twice of that to 4.
class WindingHeat {
 public:
  /// `continuous` in N or N m, `time` in s; a model without either stays cold.
  WindingHeat(double continuous = 0, double time = 0) : continuous_(continuous), time_(time) {}
  /// `effort` (N or N m) has acted for `seconds`.
  void add(double effort, double seconds) noexcept;
  /// The largest effort now: all of it up to a share of 0.8, and from there on linearly down to the continuous one at
  /// 1, which is therefore not exceeded where a cycle is short against `time`.
  [[nodiscard]] double most(double effort_max) const noexcept;
  [[nodiscard]] double share() const { return share_; }

 private:
  double continuous_, time_;
  double share_ = 0;
};

/// Takes efforts that have been shortened to the limits of the axes, and gives what the motors get. No effort becomes
/// larger or turns round. In this order:
/// - a motor that is too warm gets less (WindingHeat);
/// - an effort grows by no more than its slew limit, and goes down as fast as it likes;
/// - where the gate holds the efforts back they go to zero within `let_go`, linearly, and stay there until the reason
///   has gone and zero has been commanded.
///
/// The speed of an axis is looked at over 10 ms, because an encoder's step is large against a shorter way.
/// One thread; allocates and waits for nothing.
class AxisGate {
 public:
  explicit AxisGate(const AxisGateLimits& limits);

  /// The line was opened anew: what was known of the handle is old.
  void reopen() noexcept;
  /// The handle is at `q` (m or rad), which is believed.
  void see(Instant sampled, const AxisValues& q, const AxisLimits& axes) noexcept;
  /// The efforts for a cycle at `now`.
  AxisValues give(Instant now, const AxisValues& wanted, const AxisLimits& axes) noexcept;
  /// What the motors get in the end, which may be less.
  void gave(Instant now, const AxisValues& efforts) noexcept;
  [[nodiscard]] GateHold hold() const { return hold_; }
  [[nodiscard]] const WindingHeat& heat(int axis) const { return heat_[static_cast<std::size_t>(axis)]; }

 private:
  void watch(Instant now, bool any_effort) noexcept;

  const AxisGateLimits limits_;
  std::array<WindingHeat, max_axes> heat_;
  AxisValues given_{};
  Instant given_at_;
  bool any_given_ = false;

  GateHold hold_ = GateHold::none;
  double held_share_ = 1;
  bool is_outside_ = false, is_fast_ = false;
  Instant outside_since_;  // with an effort
  bool looks_ = false;     // a place to look from is set
  Instant looked_;
  AxisValues looked_q_{};
};

}  // namespace tactor
