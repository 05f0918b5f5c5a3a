// The velocity of a handle from what its encoders show: Kalman filters of constant acceleration.
#pragma once

#include <array>
#include <cstddef>

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
/// With `adapts`, q grows where the motion departs from the model for a while (adjustable process noise, ibid. ch.
/// 11.2): with e the mean of |innovation|^2 by its variance, fading over 20 ms, 3 where model and motion agree, q is
/// multiplied by clamp((e/4)^2, 1, 100). One sample counts for 100 at most.
class MotionModel {
 public:
  /// `departure` in 10 ms and the samples' standard deviation `noise`, both above zero, m or rad.
  MotionModel(double departure, double noise, bool adapts = false);

  /// Forgets all; `value` is where the motion starts, at rest as far as is known.
  void start(const Vec3& value);
  /// Moves the estimate on by `interval` > 0 s.
  void predict(double interval);
  /// Takes a sample in; returns how likely it was: the logarithm of its density, up to a constant, no higher than for
  /// an innovation of the size that is expected, and no lower than for one of ten standard deviations. So the steps of
  /// an encoder, between which nothing changes, do not make a restless model likely.
  double correct(const Vec3& sample);

  /// From here on values are counted from `value`.
  void count_from(const Vec3& value) { value_ += -1 * value; }

  [[nodiscard]] const Vec3& value() const { return value_; }
  [[nodiscard]] const Vec3& rate() const { return rate_; }

 private:
  double density_;   // q of the model
  double variance_;  // of a sample
  bool adapts_;
  double surprise_ = 0;  // e
  double memory_ = 0;    // the share of the next sample in e
  Vec3 value_, rate_, acceleration_;
  std::array<double, 6> P_{};  // the covariance: 00, 01, 02, 11, 12, 22
};

/// How the velocity of a handle is estimated.
enum class VelocityFilter {
  several,  ///< several models side by side
  one,      ///< one model that adapts
};

/// `several`: models side by side, of departures d/4, d, 4 d, ... 256 d, each weighted by how likely it made the
/// samples of the last 0.1 s: w_i ~ exp(sum_k e^(-age_k / 0.1 s) log p_i(k)) (multiple-model estimation, ibid.
/// ch. 11.6.2, with fading memory in place of constant weights). What it tells is their mean. So a hand that rests is
/// smoothed, and one that trembles or is shaken by a stiff contact is followed without the lag with which a damper on
/// the velocity would drive it. A wild sample alone changes no weights to speak of. `one`: a single model of departure
/// d that adapts.
class MotionFilter {
 public:
  static constexpr std::size_t models = 6;

  /// `departure` of the second model, or of the only one, `noise` of all.
  MotionFilter(double departure, double noise, VelocityFilter kind = VelocityFilter::several);

  void start(const Vec3& value);
  /// Takes in a sample that is `interval` > 0 s later than the last.
  void take(double interval, const Vec3& sample);
  /// From here on values are counted from value().
  void count_from_here();

  [[nodiscard]] const Vec3& value() const { return value_; }
  [[nodiscard]] const Vec3& rate() const { return rate_; }
  /// Of each model, their sum being 1.
  [[nodiscard]] const std::array<double, models>& weights() const { return weights_; }

 private:
  void mix();

  std::size_t count_;  // of the models in use, the first
  std::array<MotionModel, models> models_;
  std::array<double, models> likelihood_{};  // logarithm, fading
  std::array<double, models> weights_{};
  Vec3 value_, rate_;
};

/// The same for a pose: the translation, and the rotation by small turns about the estimate.
class PoseFilter {
 public:
  PoseFilter(double departure, double noise, double departure_angle, double noise_angle, bool rotate,
             VelocityFilter kind = VelocityFilter::several);

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
