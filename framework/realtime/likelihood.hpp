// How likely each of several models made the samples of the last tenth of a second, axis by axis.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "framework/core/spatial.hpp"

namespace tactor {

/// The logarithm of the density of a sample, up to a constant: -(e^2 + log(variance)) / 2 for each coordinate of
/// `innovation` e, in standard deviations. It is no higher than for an innovation of sqrt(3) standard deviations, and
/// no lower than for one of six. So a model is not more likely because it follows each step of an encoder, and a wild
/// sample alone changes little. `log_variance`: of the innovation, by anything that all models share.
inline Vec3 log_likelihood(const Vec3& innovation, double log_variance) {
  Vec3 likely;
  for (int axis = 0; axis < 3; ++axis) {
    likely[axis] = -0.5 * (std::clamp(innovation[axis] * innovation[axis], 3.0, 36.0) + log_variance);
  }
  return likely;
}

/// Sums of log_likelihood() over the samples, each e^(-age / 0.1 s) of what it was.
template <std::size_t models>
class FadingLikelihood {
 public:
  void fade(double interval) {
    const double kept = std::exp(-interval / 0.1);
    for (Vec3& sum : sums_) sum *= kept;
  }
  void add(std::size_t model, const Vec3& likely) { sums_[model] += likely; }
  [[nodiscard]] const Vec3& sum(std::size_t model) const { return sums_[model]; }
  void set(std::size_t model, const Vec3& sum) { sums_[model] = sum; }
  /// The largest sum of the first `count` models, by axis.
  [[nodiscard]] Vec3 most(std::size_t count = models) const {
    Vec3 most = sums_[0];
    for (std::size_t i = 1; i < count; ++i) {
      for (int axis = 0; axis < 3; ++axis) most[axis] = std::max(most[axis], sums_[i][axis]);
    }
    return most;
  }

  /// The share of each of the first `count` models in the whole, by axis; they add up to 1.
  void shares(std::array<Vec3, models>& share, std::size_t count = models) const {
    const Vec3 likeliest = most(count);
    for (int axis = 0; axis < 3; ++axis) {
      double whole = 0;
      for (std::size_t i = 0; i < count; ++i) whole += share[i][axis] = std::exp(sums_[i][axis] - likeliest[axis]);
      for (std::size_t i = 0; i < count; ++i) share[i][axis] /= whole;
    }
  }

 private:
  std::array<Vec3, models> sums_{};
};

}  // namespace tactor
