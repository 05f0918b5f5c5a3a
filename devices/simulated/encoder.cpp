#include "devices/simulated/encoder.hpp"

#include <numbers>

namespace tactor {

namespace {

Vec3 rounded(const Vec3& value, double step) {
  return {step * std::round(value.x / step), step * std::round(value.y / step), step * std::round(value.z / step)};
}

}  // namespace

Encoder::Encoder(double step, double step_angle, double cutoff, bool rotate)
    : step_(step), step_angle_(step_angle), cutoff_(cutoff), rotate_(rotate) {}

MotionState Encoder::read(const MotionState& truth, Time now) {
  MotionState shown = truth;
  if (step_ > 0) shown.X.p = rounded(truth.X.p, step_);
  if (rotate_ && step_angle_ > 0) {
    shown.X.R = from_rotation_vector(rounded(to_rotation_vector(truth.X.R), step_angle_));
  }
  const double dt = (now - last_).seconds();
  if (!started_) {
    // The handle was there before the run: nothing to take a difference of yet.
    if (step_ > 0) shown.V.v = {};
    if (step_angle_ > 0) shown.V.w = {};
  } else if (dt > 0) {
    const double share = 1.0 - std::exp(-2 * std::numbers::pi * cutoff_ * dt);
    if (step_ > 0) shown.V.v = shown_.V.v + share * ((shown.X.p - shown_.X.p) / dt - shown_.V.v);
    if (rotate_ && step_angle_ > 0) {
      const Vec3 turn_W = to_rotation_vector(shown.X.R * inverse(shown_.X.R));
      shown.V.w = shown_.V.w + share * (turn_W / dt - shown_.V.w);
    }
  } else {
    shown.V = shown_.V;
  }
  started_ = true;
  last_ = now;
  shown_ = shown;
  return shown;
}

}  // namespace tactor
