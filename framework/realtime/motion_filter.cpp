#include "framework/realtime/motion_filter.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

constexpr double memory_time_one = 0.02;  // s, of the mean of squared innovations of a model that adapts
constexpr double calm = 4;                // that mean, up to which the model holds
constexpr double largest_increase = 100;  // of q
constexpr double most_surprising = 100;   // a squared innovation by its variance, of three axes
constexpr double first_departure = 0.25;  // of the models of an order
constexpr double ratio_of_departures = 4;
constexpr double departure_of_order_4 = 0.25;  // by that of order 3
constexpr std::size_t models_of_order_3 = MotionFilter::models / 2;

MotionModel make_model(bool alone, double departure, double noise, std::size_t i) {
  if (alone) return MotionModel(departure, noise, 3, true);
  const MotionFilter::Chain chain = MotionFilter::chain(i);
  return MotionModel(chain.departure * departure, noise, chain.order);
}

template <std::size_t... i>
std::array<MotionModel, sizeof...(i)> make_models(bool alone, double departure, double noise,
                                                  std::index_sequence<i...>) {
  return {make_model(alone, departure, noise, i)...};
}

constexpr std::array<double, MotionModel::most_order> factorial{1, 1, 2, 6};

using Powers = std::array<double, 2 * MotionModel::most_order>;

/// T^0, T^1, ...
Powers powers_of(double T) {
  Powers powers{1};
  for (std::size_t k = 1; k < powers.size(); ++k) powers[k] = T * powers[k - 1];
  return powers;
}

/// Q_ij of a model with q = 1 over the interval whose powers are given.
double process_noise(std::size_t order, std::size_t i, std::size_t j, const Powers& powers) {
  const std::size_t a = order - 1 - i, b = order - 1 - j;
  return powers[a + b + 1] / (factorial[a] * factorial[b] * static_cast<double>(a + b + 1));
}

}  // namespace

MotionModel::MotionModel(double departure, double noise, std::size_t order, bool adapts)
    : order_(order),
      density_(departure * departure / process_noise(order, 0, 0, powers_of(0.01))),
      variance_(noise * noise),
      adapts_(adapts) {
  TACTOR_DEMAND(departure > 0 && noise > 0 && (order == 3 || order == 4));
}

void MotionModel::start(const Vec3& value) {
  state_ = {value};
  surprise_ = 0;
  P_ = {};
  P_[0][0] = variance_;
}

void MotionModel::predict(double T) {
  const double above = surprise_ / calm;
  const double q = density_ * std::clamp(above * above, 1.0, largest_increase);
  if (adapts_) memory_ = 1 - std::exp(-T / memory_time_one);
  const Powers powers = powers_of(T);
  // F_ij = T^(j-i) / (j-i)!, upwards from the diagonal.
  std::array<double, most_order> F;
  for (std::size_t k = 0; k < most_order; ++k) F[k] = powers[k] / factorial[k];
  for (std::size_t i = 0; i < order_; ++i) {
    for (std::size_t j = i + 1; j < order_; ++j) {
      state_[i] += F[j - i] * state_[j];
      for (std::size_t k = 0; k < order_; ++k) P_[i][k] += F[j - i] * P_[j][k];
    }
  }
  for (std::size_t i = 0; i < order_; ++i) {
    for (std::size_t k = 0; k < order_; ++k) {
      for (std::size_t j = k + 1; j < order_; ++j) P_[i][k] += F[j - k] * P_[i][j];
    }
  }
  for (std::size_t i = 0; i < order_; ++i) {
    for (std::size_t j = 0; j < order_; ++j) P_[i][j] += q * process_noise(order_, i, j, powers);
  }
}

Vec3 MotionModel::correct(const Vec3& sample) {
  // After a long gap rounding may leave no variance; then nothing is known but the sample, and it is no merit to meet
  // it.
  bool known = true;
  for (std::size_t i = 0; i < order_; ++i) known = known && P_[i][i] > 0;
  if (!known) {
    start(sample);
    return log_likelihood({1e3, 1e3, 1e3}, 0);
  }
  const Vec3 innovation = sample - state_[0];
  const std::array<double, most_order> row = P_[0];
  const double s = row[0] + variance_;
  const double surprising = dot(innovation, innovation) / s;
  surprise_ += memory_ * (std::min(surprising, most_surprising) - surprise_);
  for (std::size_t i = 0; i < order_; ++i) {
    state_[i] += (row[i] / s) * innovation;
    // The first row without a difference, and symmetric to the bit, so that rounding makes no variance negative.
    for (std::size_t j = i; j < order_; ++j) {
      P_[i][j] = P_[j][i] = i == 0 ? variance_ * row[j] / s : P_[i][j] - row[i] * row[j] / s;
    }
  }
  return log_likelihood(innovation / std::sqrt(s), std::log(s / variance_));
}

MotionFilter::Chain MotionFilter::chain(std::size_t i) {
  const bool third = i < models_of_order_3;
  const auto step = static_cast<double>(third ? i : i - models_of_order_3);
  const double speed = first_departure * std::pow(ratio_of_departures, step);
  if (third) return {3, speed, speed};
  return {4, speed, departure_of_order_4 * speed};
}

MotionFilter::MotionFilter(double departure, double noise, bool alone)
    : count_(alone ? 1 : models), models_(make_models(alone, departure, noise, std::make_index_sequence<models>())) {
  mix();
}

void MotionFilter::start(const Vec3& value) {
  for (MotionModel& model : models_) model.start(value);
  likelihood_ = {};
  mix();
}

void MotionFilter::update(double interval, const Vec3& sample) {
  likelihood_.fade(interval);
  for (std::size_t i = 0; i < count_; ++i) {
    models_[i].predict(interval);
    likelihood_.add(i, models_[i].correct(sample));
  }
}

void MotionFilter::count_from(const Vec3& value) {
  for (MotionModel& model : models_) model.count_from(value);
  value_ += -1 * value;
}

/// The means by the likelihoods, axis by axis.
void MotionFilter::mix() {
  likelihood_.shares(weights_, count_);
  value_ = rate_ = {};
  for (std::size_t i = 0; i < count_; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      value_[axis] += weights_[i][axis] * models_[i].value()[axis];
      rate_[axis] += weights_[i][axis] * models_[i].rate()[axis];
    }
  }
}

}  // namespace tactor
