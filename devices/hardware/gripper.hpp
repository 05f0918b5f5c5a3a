// The gripper of a device: how far it is open and how fast, and what its motor is given.
#pragma once

#include <algorithm>
#include <cmath>

#include "framework/core/messages.hpp"
#include "framework/realtime/device_node.hpp"
#include "framework/realtime/pose_filter.hpp"

namespace tactor {

/// Its velocity is that of a PoseFilter. A force goes to the motor as far as the device's gate is open: it is zero
/// where the gate is, and where nothing newer than stale_after has come. From zero to the largest force it takes
/// `engage_time` at least, and as long back.
class Gripper {
 public:
  /// `noise` in m, of the opening; `interval` in s, between samples.
  Gripper(const DeviceParams& limits, double noise, double interval)
      : stale_after_(limits.stale_after),
        engage_time_(limits.engage_time),
        longest_tick_(Duration::from_seconds(2 / limits.rate)),
        filter_(VelocityParams{}, noise, 1, interval, false) {}

  /// `opening` in m, of a later sample than the one before.
  GripperState take(double opening, Time t) noexcept {
    filter_.take({{opening, 0, 0}, {}}, t);
    return {opening, filter_.velocity().v.x};
  }
  /// N, for the tick at `now`; `gain` of the gate, `most` in N of the motor.
  double force(Time now, const Stamped<GripperForce>* wanted, double gain, double most) noexcept {
    const bool fresh =
        wanted != nullptr && now - wanted->stamp.valid < stale_after_ && std::isfinite(wanted->value.force);
    const double target = fresh ? gain * std::clamp(wanted->value.force, -most, most) : 0;
    const Duration elapsed = std::clamp(now - ticked_, Duration{}, longest_tick_);
    const double step = most * elapsed.seconds() / engage_time_.seconds();
    ticked_ = now;
    force_ = gain > 0 ? std::clamp(target, force_ - step, force_ + step) : 0;
    return force_;
  }
  /// The motor has let go.
  void let_go() noexcept { force_ = 0; }

 private:
  Duration stale_after_, engage_time_, longest_tick_;
  PoseFilter filter_;
  Time ticked_;
  double force_ = 0;
};

}  // namespace tactor
