// The velocity of a handle from what its encoders show: a Kalman filter of constant acceleration.
#pragma once

#include <array>

#include "framework/core/spatial.hpp"
#include "framework/core/time.hpp"

namespace tactor {

/// Estimates position, rate and acceleration of one kind of motion, translation or rotation, from its samples. The
/// model is white jerk of spectral density q (m^2/s^5 or rad^2/s^5), so that the process noise of an interval T is
///   q [T^5/20 T^4/8 T^3/6; T^4/8 T^3/3 T^2/2; T^3/6 T^2/2 T]
/// (Y. Bar-Shalom, X. Li, T. Kirubarajan, Estimation with Applications to Tracking and Navigation, 2001, ch. 6.2.3). q
/// is given by the departure d from constant acceleration in 10 ms, of which it makes the variance d^2 = q T^5/20. The
/// three axes share gains and variances. Against a low-pass on differences of the same noise it is less late.
///
/// Where the motion departs from the model for a while, q grows (adjustable process noise, ibid. ch. 11.2): with e the
/// mean of |innovation|^2 by its variance, fading over 20 ms, 3 where model and motion agree, q is multiplied by
/// clamp((e/4)^2, 1, 100). A filter made for a calm hand would else be so late where a stiff contact shakes the handle
/// that a damper on its velocity drives instead of damps. One sample counts for 100 at most, so that a wild one makes
/// no larger velocity than with q as it is.
class MotionFilter {
 public:
  /// `departure` in 10 ms and the samples' standard deviation `noise`, both above zero, m or rad.
  MotionFilter(double departure, double noise);

  /// Forgets all; `value` is where the motion starts, at rest as far as is known.
  void start(const Vec3& value);
  /// Moves the estimate on by `interval` > 0 s.
  void predict(double interval);
  /// Takes a sample in, given as its difference from the prediction.
  void correct(const Vec3& innovation);

  /// From here on values are counted from the estimate.
  void count_from_here() { value_ = {}; }

  [[nodiscard]] const Vec3& value() const { return value_; }
  [[nodiscard]] const Vec3& rate() const { return rate_; }

 private:
  double density_;       // q of the model
  double variance_;      // of a sample
  double surprise_ = 0;  // e
  double memory_ = 0;    // the share of the next sample in e
  Vec3 value_, rate_, acceleration_;
  std::array<double, 6> P_{};  // the covariance: 00, 01, 02, 11, 12, 22
};

/// The same for a pose: the translation, and the rotation by small turns about the estimate.
class PoseFilter {
 public:
  PoseFilter(double departure, double noise, double departure_angle, double noise_angle, bool rotate);

  /// Takes in the pose at `now`; one that is not later than the last, or not finite, is left out.
  void take(const Pose& X_WD, Time now);
  /// m/s and rad/s in W; the angular one zero where nothing rotates.
  [[nodiscard]] Twist velocity() const { return {translation_.rate(), rotation_.rate()}; }

 private:
  MotionFilter translation_, rotation_;
  bool rotate_;
  bool started_ = false;
  Time last_;
  Quat R_;  // the estimate
};

}  // namespace tactor
