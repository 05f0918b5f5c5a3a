#include "nodes/source/decimate.hpp"

#include <cmath>
#include <numbers>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

constexpr std::size_t new_periods_a_side = 5;
constexpr double share_of_half_the_rate = 0.8;

/// The weights of the sample itself and of those 1, 2, ... from it on either side.
std::vector<double> half_of_weights(std::size_t factor) {
  const std::size_t side = new_periods_a_side * factor;
  const double cutoff = 0.5 * share_of_half_the_rate / static_cast<double>(factor);  // periods a sample
  std::vector<double> weights(side + 1);
  double sum = 0;
  for (std::size_t i = 0; i <= side; ++i) {
    const double x = std::numbers::pi * static_cast<double>(i);
    const double sinc = i == 0 ? 2 * cutoff : std::sin(2 * cutoff * x) / x;
    weights[i] = sinc * (0.54 + 0.46 * std::cos(x / static_cast<double>(side)));
    sum += i == 0 ? weights[i] : 2 * weights[i];
  }
  for (double& weight : weights) weight /= sum;
  return weights;
}

void expect_even(const std::vector<Stamped<Wrench>>& samples, const std::string& where) {
  const double mean =
      (samples.back().stamp.valid - samples.front().stamp.valid).seconds() / static_cast<double>(samples.size() - 1);
  for (std::size_t i = 1; i < samples.size(); ++i) {
    const double step = (samples[i].stamp.valid - samples[i - 1].stamp.valid).seconds();
    if (std::abs(step - mean) > 0.01 * mean) {
      throw InputError(where + ": expected evenly spaced samples, one every " + std::to_string(1e3 * mean) +
                       " ms, found " + std::to_string(1e3 * step) + " ms before the one at " +
                       std::to_string(samples[i].stamp.valid.seconds()) + " s");
    }
  }
}

}  // namespace

std::vector<Stamped<Wrench>> decimated(std::vector<Stamped<Wrench>> samples, int factor, const std::string& where) {
  TACTOR_DEMAND(factor >= 1);
  if (factor == 1) return samples;
  const auto step = static_cast<std::size_t>(factor);
  const std::vector<double> weights = half_of_weights(step);
  const std::size_t least = 2 * weights.size() - 1;
  if (samples.size() < least) {
    throw InputError(where + ": expected at least " + std::to_string(least) + " samples, found " +
                     std::to_string(samples.size()));
  }
  expect_even(samples, where);
  const std::size_t last = samples.size() - 1;
  const auto before = [&](std::size_t i, std::size_t by) {
    return by <= i ? samples[i - by].value : 2.0 * samples.front().value - samples[by - i].value;
  };
  const auto after = [&](std::size_t i, std::size_t by) {
    return i + by <= last ? samples[i + by].value : 2.0 * samples.back().value - samples[2 * last - i - by].value;
  };
  std::vector<Stamped<Wrench>> result;
  for (std::size_t i = 0; i <= last; i += step) {
    Wrench sum = weights[0] * samples[i].value;
    for (std::size_t by = 1; by < weights.size(); ++by) sum = sum + weights[by] * (before(i, by) + after(i, by));
    result.push_back({samples[i].stamp, sum});
  }
  return result;
}

}  // namespace tactor
