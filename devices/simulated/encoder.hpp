// What a device's encoders show of its motion: steps of position, and a velocity estimated from them.
#pragma once

#include "devices/simulated/motion.hpp"
#include "framework/core/time.hpp"

namespace tactor {

/// Rounds each coordinate to the nearest multiple of a step, and the rotation vector likewise. The velocity is the
/// backward difference of what is shown through a first-order low-pass,
///   v_k = v_{k-1} + (1 - exp(-2 pi f_c dt)) (dx/dt - v_{k-1}),
/// or the true one where the step is 0.
class Encoder {
 public:
  /// Steps in m and rad, cut-off in Hz.
  Encoder(double step, double step_angle, double cutoff, bool rotate);

  /// What is shown of `truth` at `now`; called once a tick.
  MotionState read(const MotionState& truth, Time now);

 private:
  double step_;
  double step_angle_;
  double cutoff_;
  bool rotate_;
  bool started_ = false;
  Time last_;
  MotionState shown_;
};

}  // namespace tactor
