#include "nodes/prediction/trend_filter.hpp"

#include <algorithm>
#include <cmath>

namespace tactor {

TrendFilter::TrendFilter(Trend trend, double departure, double noise, double gate)
    : trend_(trend), variance_(noise * noise), gate_(gate) {
  constexpr double T = departure_time;
  const bool accelerates = trend == Trend::constant_acceleration;
  density_ = departure * departure * (accelerates ? 20 / std::pow(T, 5) : 3 / std::pow(T, 3));
  // Ten thousand times the change that noise and departure make: as good as unknown, and digits are left.
  const double unknown = 1e4 * std::max(departure, noise);
  rate_prior_ = unknown * unknown / (T * T);
  curvature_prior_ = accelerates ? unknown * unknown / (T * T * T * T) : 0;
}

void TrendFilter::start(const Vec3& sample) {
  state_ = {sample, Vec3{}, Vec3{}};
  P_.setZero();
  P_.diagonal() << variance_, rate_prior_, curvature_prior_;
  started_ = true;
}

void TrendFilter::take(double interval, const Vec3& sample) {
  if (!started_) {
    start(sample);
    return;
  }
  const double T = interval;
  state_ = {ahead(T), state_[1] + T * state_[2], state_[2]};
  Eigen::Matrix3d F;
  F << 1, T, T * T / 2, 0, 1, T, 0, 0, 1;
  Eigen::Matrix3d Q;
  if (trend_ == Trend::constant_acceleration) {
    const double T2 = T * T;
    Q << T2 * T2 * T / 20, T2 * T2 / 8, T2 * T / 6, T2 * T2 / 8, T2 * T / 3, T2 / 2, T2 * T / 6, T2 / 2, T;
  } else {
    Q << T * T * T / 3, T * T / 2, 0, T * T / 2, T, 0, 0, 0, 0;
  }
  P_ = (F * P_ * F.transpose() + density_ * Q).eval();

  const Vec3 innovation = sample - state_[0];
  const double expected = P_(0, 0) + variance_;
  // Written so that NaN starts anew as well.
  if (!(dot(innovation, innovation) <= gate_ * gate_ * expected)) {
    ++restarts_;
    start(sample);
    return;
  }
  const Eigen::Vector3d gain = P_.col(0) / expected;
  for (int i = 0; i < 3; ++i) state_[static_cast<std::size_t>(i)] += gain[i] * innovation;
  Eigen::Matrix3d kept = Eigen::Matrix3d::Identity();
  kept.col(0) -= gain;
  P_ = (kept * P_ * kept.transpose() + variance_ * gain * gain.transpose()).eval();
}

Vec3 TrendFilter::ahead(double time) const {
  return state_[0] + time * state_[1] + (0.5 * time * time) * state_[2];
}

}  // namespace tactor
