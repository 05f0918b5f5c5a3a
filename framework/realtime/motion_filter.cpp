#include "framework/realtime/motion_filter.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

constexpr double memory_time = 0.1;       // s, of the likelihoods
constexpr double memory_time_one = 0.02;  // s, of the mean of squared innovations of a model that adapts
constexpr double calm = 4;                // that mean, up to which the model holds
constexpr double largest_increase = 100;  // of q
constexpr double expected = 3;            // a squared innovation by its variance, of three axes
constexpr double most_surprising = 100;   // the same
constexpr double first_departure = 0.25;  // of the models
constexpr double ratio_of_departures = 4;

template <std::size_t... i>
std::array<MotionModel, sizeof...(i)> make_models(VelocityFilter kind, double departure, double noise,
                                                  std::index_sequence<i...>) {
  if (kind == VelocityFilter::one) return {((void)i, MotionModel(departure, noise, true))...};
  return {MotionModel(departure * first_departure * std::pow(ratio_of_departures, static_cast<double>(i)), noise)...};
}

}  // namespace

MotionModel::MotionModel(double departure, double noise, bool adapts)
    : density_(20 * departure * departure / std::pow(0.01, 5)), variance_(noise * noise), adapts_(adapts) {
  TACTOR_DEMAND(departure > 0 && noise > 0);
}

void MotionModel::start(const Vec3& value) {
  value_ = value;
  rate_ = acceleration_ = {};
  surprise_ = 0;
  P_ = {variance_, 0, 0, 0, 0, 0};
}

void MotionModel::predict(double T) {
  value_ += T * rate_ + (0.5 * T * T) * acceleration_;
  rate_ += T * acceleration_;
  // F P F^T + q Q with F = [1 T T^2/2; 0 1 T; 0 0 1].
  const auto [p00, p01, p02, p11, p12, p22] = P_;
  const double above = surprise_ / calm;
  const double T2 = T * T, q = density_ * std::clamp(above * above, 1.0, largest_increase);
  if (adapts_) memory_ = 1 - std::exp(-T / memory_time_one);
  const double a0 = p00 + T * p01 + 0.5 * T2 * p02, a1 = p01 + T * p11 + 0.5 * T2 * p12,
               a2 = p02 + T * p12 + 0.5 * T2 * p22;
  const double b1 = p11 + T * p12, b2 = p12 + T * p22;
  P_ = {a0 + T * a1 + 0.5 * T2 * a2 + q * T2 * T2 * T / 20,
        a1 + T * a2 + q * T2 * T2 / 8,
        a2 + q * T2 * T / 6,
        b1 + T * b2 + q * T2 * T / 3,
        b2 + q * T2 / 2,
        p22 + q * T};
}

double MotionModel::correct(const Vec3& sample) {
  const Vec3 innovation = sample - value_;
  const auto [p00, p01, p02, p11, p12, p22] = P_;
  const double s = p00 + variance_, k0 = p00 / s, k1 = p01 / s, k2 = p02 / s;
  const double surprising = dot(innovation, innovation) / s;
  surprise_ += memory_ * (std::min(surprising, most_surprising) - surprise_);
  value_ += k0 * innovation;
  rate_ += k1 * innovation;
  acceleration_ += k2 * innovation;
  P_ = {variance_ * k0, variance_ * k1, variance_ * k2, p11 - k1 * p01, p12 - k1 * p02, p22 - k2 * p02};
  return -0.5 * (std::clamp(surprising, expected, most_surprising) + 3 * std::log(s / variance_));
}

MotionFilter::MotionFilter(double departure, double noise, VelocityFilter kind)
    : count_(kind == VelocityFilter::one ? 1 : models),
      models_(make_models(kind, departure, noise, std::make_index_sequence<models>())) {
  mix();
}

void MotionFilter::start(const Vec3& value) {
  for (MotionModel& model : models_) model.start(value);
  likelihood_ = {};
  mix();
}

void MotionFilter::take(double interval, const Vec3& sample) {
  const double kept = std::exp(-interval / memory_time);
  for (std::size_t i = 0; i < count_; ++i) {
    models_[i].predict(interval);
    likelihood_[i] = kept * likelihood_[i] + models_[i].correct(sample);
  }
  mix();
}

void MotionFilter::count_from_here() {
  for (MotionModel& model : models_) model.count_from(value_);
  value_ = {};
}

/// The means by the likelihoods.
void MotionFilter::mix() {
  const double most = *std::max_element(likelihood_.begin(), likelihood_.begin() + static_cast<std::ptrdiff_t>(count_));
  double sum = 0;
  for (std::size_t i = 0; i < count_; ++i) sum += weights_[i] = std::exp(likelihood_[i] - most);
  value_ = rate_ = {};
  for (std::size_t i = 0; i < count_; ++i) {
    weights_[i] /= sum;
    value_ += weights_[i] * models_[i].value();
    rate_ += weights_[i] * models_[i].rate();
  }
}

PoseFilter::PoseFilter(double departure, double noise, double departure_angle, double noise_angle, bool rotate,
                       VelocityFilter kind)
    : translation_(departure, noise, kind), rotation_(departure_angle, noise_angle, kind), rotate_(rotate) {}

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
  translation_.take(interval, X_WD.p);
  if (!rotate_) return;
  // Values are the turn from R_.
  rotation_.take(interval, to_rotation_vector(X_WD.R * inverse(R_)));
  R_ = from_rotation_vector(rotation_.value()) * R_;
  rotation_.count_from_here();
}

}  // namespace tactor
