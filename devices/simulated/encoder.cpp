#include "devices/simulated/encoder.hpp"

#include <cmath>

namespace tactor {

namespace {

Vec3 rounded(const Vec3& value, double step) {
  return {step * std::round(value.x / step), step * std::round(value.y / step), step * std::round(value.z / step)};
}

/// An exact encoder shows the velocity as it is; of another it has to be estimated.
bool is_exact(double step, double noise) {
  return !(step > 0 || noise > 0);
}

/// The standard deviation of noise and of rounding to a step; any, where there is neither and the filter is not asked.
double deviation_of(double step, double noise) {
  return is_exact(step, noise) ? 1 : std::hypot(step / std::sqrt(12.0), noise);
}

}  // namespace

Encoder::Encoder(const EncoderParameters& parameters, bool rotate)
    : parameters_(parameters), rotate_(rotate), engine_(parameters.seed) {
  const bool estimates_angular = rotate && !is_exact(parameters.step_angle, parameters.noise_angle);
  if (is_exact(parameters.step, parameters.noise) && !estimates_angular) return;
  filter_.emplace(parameters.velocity, deviation_of(parameters.step, parameters.noise),
                  deviation_of(parameters.step_angle, parameters.noise_angle), parameters.interval, estimates_angular);
}

std::optional<double> Encoder::mixed_share() const {
  if (!filter_ || is_exact(parameters_.step, parameters_.noise)) return std::nullopt;
  return filter_->mixed_share();
}

Vec3 Encoder::noisy(const Vec3& value, double deviation) {
  // One after the other, so that the order of the draws is that of the axes.
  const double x = normal_(engine_);
  const double y = normal_(engine_);
  const double z = normal_(engine_);
  return value + deviation * Vec3{x, y, z};
}

MotionState Encoder::read(const MotionState& truth, Time now) {
  const EncoderParameters& p = parameters_;
  MotionState shown = truth;
  if (p.noise > 0) shown.X.p = noisy(shown.X.p, p.noise);
  if (p.step > 0) shown.X.p = rounded(shown.X.p, p.step);
  if (rotate_ && (p.step_angle > 0 || p.noise_angle > 0)) {
    Vec3 r_W = to_rotation_vector(truth.X.R);
    if (p.noise_angle > 0) r_W = noisy(r_W, p.noise_angle);
    if (p.step_angle > 0) r_W = rounded(r_W, p.step_angle);
    shown.X.R = from_rotation_vector(r_W);
  }
  if (!filter_) return shown;
  filter_->take(shown.X, now);
  const Twist estimate = filter_->velocity();
  if (!is_exact(p.step, p.noise)) shown.V.v = estimate.v;
  if (!is_exact(p.step_angle, p.noise_angle)) shown.V.w = estimate.w;
  return shown;
}

}  // namespace tactor
