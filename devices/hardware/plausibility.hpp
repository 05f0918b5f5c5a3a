// Whether what the encoders of a device show can be: jumps, and encoders that stand still under a force.
#pragma once

#include <cstdint>

#include "devices/hardware/axis_limits.hpp"
#include "framework/core/spatial.hpp"
#include "framework/core/time.hpp"
#include "framework/realtime/monotonic_clock.hpp"

namespace tactor {

/// Judges samples one by one.
///
/// A jump: between two samples an axis went further than speed_max times the time between them plus its tolerance; an
/// orientation, by the angle between its two quaternions. From then on nothing is believed, however often it repeats,
/// until all axes are back within the reach that was exceeded, around the last sample that was believed: a wild value
/// passes, an encoder that has lost its count does not.
///
/// A stuck encoder: while an axis was driven with at least stuck_share of its effort_max its coordinate stayed the same
/// to the last bit for stuck_after. It is believed again when it has changed. A gripper may hold something still.
class Plausibility {
 public:
  enum class Verdict : std::uint8_t { good, jumped, stuck };

  explicit Plausibility(const AxisLimits& limits) : limits_(limits) {}

  /// Other limits from now on, of the same axes.
  void set(const AxisLimits& limits) { limits_ = limits; }
  /// `effort` is what drove the axes when the sample was taken. Where an orientation is shown, sets its three axes: the
  /// sum of the small rotations in the base since the first sample (rad), which has no end and no jump.
  Verdict judge(LinkSample& sample, Instant sampled, const AxisValues& effort) noexcept;

  /// What the last verdict that was not good is about.
  struct Finding {
    int axis = 0;
    double from = 0, to = 0;  ///< m or rad; of an orientation 0, and the angle
    Duration time;            ///< of the jump, or for which it has stood still
  };
  [[nodiscard]] const Finding& finding() const { return finding_; }
  [[nodiscard]] std::uint64_t jumps() const { return jumps_; }
  [[nodiscard]] std::uint64_t times_stuck() const { return times_stuck_; }

 private:
  [[nodiscard]] bool is_finite(const LinkSample& sample) const;
  bool jumped(const LinkSample& sample, const Vec3& turned, Instant sampled) noexcept;
  bool jumped_by(int axis, double from, double to, Duration time) noexcept;
  bool stuck(const AxisValues& q, Instant sampled, const AxisValues& effort) noexcept;

  AxisLimits limits_;
  bool any_ = false;
  LinkSample believed_;  // the last sample without a jump
  Instant believed_at_;
  bool distrusted_ = false;
  Duration reach_time_;  // of the jump
  AxisValues last_{};
  std::array<bool, max_axes> driven_{};
  std::array<bool, max_axes> stands_{};  // found stuck, and not changed since
  std::array<Instant, max_axes> still_since_{};
  Finding finding_;
  std::uint64_t jumps_ = 0, times_stuck_ = 0;
};

}  // namespace tactor
