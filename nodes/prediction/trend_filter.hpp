// A Kalman filter for vector samples that change smoothly.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "framework/core/spatial.hpp"

namespace tactor {

/// Which derivative of the value is white noise.
enum class Trend {
  constant_velocity,      ///< the second: between samples the value goes on in a line
  constant_acceleration,  ///< the third: in a parabola
};

/// State (x, x', x'') of each axis, x'' = 0 with constant velocity; F = [1 T T^2/2; 0 1 T; 0 0 1]. The driving noise of
/// spectral density q gives, exactly and for every interval T, Q = q [T^3/3 T^2/2; T^2/2 T] or
/// q [T^5/20 T^4/8 T^3/6; T^4/8 T^3/3 T^2/2; T^3/6 T^2/2 T]. The three axes share one covariance and therefore one
/// gain, so a rotation of the world rotates the estimate. The covariance is updated in Joseph form, which keeps it
/// symmetric and positive. Before the second sample nothing is known of the derivatives. Source: Bar-Shalom, Li,
/// Kirubarajan, "Estimation with Applications to Tracking and Navigation", 2001, section 6.2.
class TrendFilter {
 public:
  /// `departure`: by how much, as a standard deviation of each axis, the value leaves its trend within
  /// `departure_time`; `noise`: the standard deviation of a sample about the value; both > 0, in the unit of the
  /// samples. A sample that is further than `gate` standard deviations from where it is expected starts the filter
  /// anew.
  TrendFilter(Trend trend, double departure, double noise, double gate);
  static constexpr double departure_time = 0.01;  ///< s

  /// Takes a sample in that came `interval` >= 0 seconds after the one before.
  void take(double interval, const Vec3& sample);
  /// What is expected `time` seconds after the last sample.
  [[nodiscard]] Vec3 ahead(double time) const;
  [[nodiscard]] std::int64_t restarts() const { return restarts_; }

 private:
  void start(const Vec3& sample);

  Trend trend_;
  double density_;   // q
  double variance_;  // of a sample
  double gate_;
  double rate_prior_, curvature_prior_;  // variances of x' and x'' before anything is known of them
  bool started_ = false;
  std::int64_t restarts_ = 0;
  std::array<Vec3, 3> state_;
  Eigen::Matrix3d P_ = Eigen::Matrix3d::Zero();
};

}  // namespace tactor
