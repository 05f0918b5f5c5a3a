// What a device's encoders show of its motion: steps of position, and a velocity estimated from them.
#pragma once

#include "devices/simulated/motion.hpp"
#include "framework/core/time.hpp"
#include "framework/realtime/motion_filter.hpp"

namespace tactor {

/// Rounds each coordinate to the nearest multiple of a step, and the rotation vector likewise. The velocity is what
/// PoseFilter makes of that, a step being noise of the variance step^2/12, or the true one where the step is 0.
class Encoder {
 public:
  /// Steps in m and rad; departures as MotionFilter has them.
  Encoder(double step, double step_angle, double departure, double departure_angle, bool rotate);

  /// What is shown of `truth` at `now`; called once a tick.
  MotionState read(const MotionState& truth, Time now);

 private:
  double step_;
  double step_angle_;
  bool rotate_;
  PoseFilter filter_;
};

}  // namespace tactor
