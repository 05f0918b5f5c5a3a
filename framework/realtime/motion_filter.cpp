#include "framework/realtime/motion_filter.hpp"

#include <algorithm>
#include <cmath>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

constexpr double memory_time = 0.02;      // s, of the mean of squared innovations
constexpr double calm = 4;                // that mean, up to which the model holds
constexpr double most_surprising = 100;   // a squared innovation
constexpr double largest_increase = 100;  // of q

}  // namespace

MotionFilter::MotionFilter(double departure, double noise)
    : density_(20 * departure * departure / std::pow(0.01, 5)), variance_(noise * noise) {
  TACTOR_DEMAND(departure > 0 && noise > 0);
}

void MotionFilter::start(const Vec3& value) {
  value_ = value;
  rate_ = acceleration_ = {};
  surprise_ = 0;
  P_ = {variance_, 0, 0, 0, 0, 0};
}

void MotionFilter::predict(double T) {
  value_ += T * rate_ + (0.5 * T * T) * acceleration_;
  rate_ += T * acceleration_;
  // F P F^T + q Q with F = [1 T T^2/2; 0 1 T; 0 0 1].
  const auto [p00, p01, p02, p11, p12, p22] = P_;
  const double above = surprise_ / calm;
  const double T2 = T * T, q = density_ * std::clamp(above * above, 1.0, largest_increase);
  const double a0 = p00 + T * p01 + 0.5 * T2 * p02, a1 = p01 + T * p11 + 0.5 * T2 * p12,
               a2 = p02 + T * p12 + 0.5 * T2 * p22;
  const double b1 = p11 + T * p12, b2 = p12 + T * p22;
  memory_ = 1 - std::exp(-T / memory_time);
  P_ = {a0 + T * a1 + 0.5 * T2 * a2 + q * T2 * T2 * T / 20,
        a1 + T * a2 + q * T2 * T2 / 8,
        a2 + q * T2 * T / 6,
        b1 + T * b2 + q * T2 * T / 3,
        b2 + q * T2 / 2,
        p22 + q * T};
}

void MotionFilter::correct(const Vec3& innovation) {
  const auto [p00, p01, p02, p11, p12, p22] = P_;
  const double s = p00 + variance_, k0 = p00 / s, k1 = p01 / s, k2 = p02 / s;
  surprise_ += memory_ * (std::min(dot(innovation, innovation) / s, most_surprising) - surprise_);
  value_ += k0 * innovation;
  rate_ += k1 * innovation;
  acceleration_ += k2 * innovation;
  P_ = {variance_ * k0, variance_ * k1, variance_ * k2, p11 - k1 * p01, p12 - k1 * p02, p22 - k2 * p02};
}

PoseFilter::PoseFilter(double departure, double noise, double departure_angle, double noise_angle, bool rotate)
    : translation_(departure, noise), rotation_(departure_angle, noise_angle), rotate_(rotate) {}

void PoseFilter::take(const Pose& X_WD, Time now) {
  const Quat& R = X_WD.R;
  // It would never be forgotten again.
  if (!is_finite(X_WD.p) || !std::isfinite(R.w + R.x + R.y + R.z)) return;
  if (!started_) {
    started_ = true;
    last_ = now;
    translation_.start(X_WD.p);
    rotation_.start({});
    R_ = X_WD.R;
    return;
  }
  const double interval = (now - last_).seconds();
  if (interval <= 0) return;
  last_ = now;
  translation_.predict(interval);
  translation_.correct(X_WD.p - translation_.value());
  if (!rotate_) return;
  // The value is the turn from R_.
  rotation_.predict(interval);
  rotation_.correct(to_rotation_vector(X_WD.R * inverse(from_rotation_vector(rotation_.value()) * R_)));
  R_ = from_rotation_vector(rotation_.value()) * R_;
  rotation_.count_from_here();
}

}  // namespace tactor
