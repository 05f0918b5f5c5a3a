#include "devices/simulated/encoder.hpp"

#include <cmath>

namespace tactor {

namespace {

Vec3 rounded(const Vec3& value, double step) {
  return {step * std::round(value.x / step), step * std::round(value.y / step), step * std::round(value.z / step)};
}

/// The standard deviation of rounding to a step; any, where there is none and the filter is not asked.
double noise_of(double step) {
  return step > 0 ? step / std::sqrt(12.0) : 1;
}

}  // namespace

Encoder::Encoder(double step, double step_angle, double departure, double departure_angle, bool rotate)
    : step_(step),
      step_angle_(step_angle),
      rotate_(rotate),
      filter_(departure, noise_of(step), departure_angle, noise_of(step_angle), rotate) {}

MotionState Encoder::read(const MotionState& truth, Time now) {
  MotionState shown = truth;
  if (step_ > 0) shown.X.p = rounded(truth.X.p, step_);
  if (rotate_ && step_angle_ > 0) {
    shown.X.R = from_rotation_vector(rounded(to_rotation_vector(truth.X.R), step_angle_));
  }
  filter_.take(shown.X, now);
  const Twist estimate = filter_.velocity();
  if (step_ > 0) shown.V.v = estimate.v;
  if (step_angle_ > 0) shown.V.w = estimate.w;
  return shown;
}

}  // namespace tactor
