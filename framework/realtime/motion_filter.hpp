// The velocity of a handle from what its encoders show: Kalman filters.
#pragma once

#include <array>
#include <cstddef>

#include "framework/core/spatial.hpp"
#include "framework/realtime/likelihood.hpp"

namespace tactor {

/// Estimates position and rate of one kind of motion, translation or rotation, from its samples. The model of order n
/// is a chain of n integrators behind white noise of spectral density q: of order 3 the jerk is white, of order 4 the
/// jerk's rate (q in m^2/s^(2n-1), or rad^2). So the process noise of an interval T is
///   Q_ij = q T^(a+b+1) / (a! b! (a+b+1)),   a = n-1-i, b = n-1-j
/// (Y. Bar-Shalom, X. Li, T. Kirubarajan, Estimation with Applications to Tracking and Navigation, 2001, ch. 6.2). q is
/// given by the departure d that the noise makes in 10 ms: Q_00 = d^2 for that interval. The three axes share gains and
/// variances. Against a low-pass on differences of the same noise it is less late.
///
/// With `adapts`, q grows where the motion departs from the model for a while (adjustable process noise, ibid. ch.
/// 11.2): with e the mean of |innovation|^2 by its variance, fading over 20 ms, 3 where model and motion agree, q is
/// multiplied by clamp((e/4)^2, 1, 100). One sample counts for 100 at most.
class MotionModel {
 public:
  static constexpr std::size_t most_order = 4;

  /// `departure` in 10 ms and the samples' standard deviation `noise`, both above zero, m or rad; `order` 3 or 4.
  MotionModel(double departure, double noise, std::size_t order = 3, bool adapts = false);

  /// Forgets all; `value` is where the motion starts, at rest as far as is known.
  void start(const Vec3& value);
  /// Moves the estimate on by `interval` > 0 s.
  void predict(double interval);
  /// Takes a sample in; returns log_likelihood() of it.
  Vec3 correct(const Vec3& sample);

  /// From here on values are counted from `value`.
  void count_from(const Vec3& value) { state_[0] += -1 * value; }

  [[nodiscard]] const Vec3& value() const { return state_[0]; }
  [[nodiscard]] const Vec3& rate() const { return state_[1]; }

 private:
  std::size_t order_;
  double density_;   // q of the model
  double variance_;  // of a sample
  bool adapts_;
  double surprise_ = 0;                 // e
  double memory_ = 0;                   // the share of the next sample in e
  std::array<Vec3, most_order> state_;  // the value and its derivatives
  std::array<std::array<double, most_order>, most_order> P_{};
};

/// Models side by side, six of order 3 with departures d/4, d, 4 d, ... 256 d, and six of order 4 with a
/// quarter of these. Each is weighted, axis by axis, by how likely it made the samples of the last 0.1 s:
///   w_i ~ exp(sum_k e^(-age_k / 0.1 s) log p_i(k))
/// (multiple-model estimation, ibid. ch. 11.6.2, with fading memory in place of constant weights). What it tells is
/// their mean. So a hand that rests is smoothed, and one that trembles or is shaken by a stiff contact is followed
/// without the lag with which a damper on the velocity would drive it. Axis by axis, because a hand may press calmly
/// while it slides. A wild sample alone changes no weights to speak of.
/// Or, as `alone`, a single model of order 3 and departure d that adapts.
class MotionFilter {
 public:
  static constexpr std::size_t models = 12;
  /// The chain of model `i`.
  struct Chain {
    std::size_t order;
    double speed;      ///< 1 for the second of its order, four times as much from one to the next
    double departure;  ///< by that of the second model
  };
  static Chain chain(std::size_t i);

  /// `departure` of the second model, or of the only one, `noise` of all.
  MotionFilter(double departure, double noise, bool alone = false);

  void start(const Vec3& value);
  /// Takes in a sample that is `interval` > 0 s later than the last.
  void take(double interval, const Vec3& sample) {
    update(interval, sample);
    mix();
  }
  /// The two halves of take(): all models take the sample in; their mean is made. For who seldom needs the mean.
  void update(double interval, const Vec3& sample);
  void mix();
  /// From here on values are counted from `value`.
  void count_from(const Vec3& value);

  [[nodiscard]] const Vec3& value() const { return value_; }
  [[nodiscard]] const Vec3& rate() const { return rate_; }
  /// Of each model and axis, the sum over the models being 1.
  [[nodiscard]] const std::array<Vec3, models>& weights() const { return weights_; }
  [[nodiscard]] const MotionModel& model(std::size_t i) const { return models_[i]; }
  [[nodiscard]] const FadingLikelihood<models>& likelihood() const { return likelihood_; }

 private:
  std::size_t count_;  // of the models in use, the first
  std::array<MotionModel, models> models_;
  FadingLikelihood<models> likelihood_;
  std::array<Vec3, models> weights_{};
  Vec3 value_, rate_;
};

}  // namespace tactor
