#include "framework/core/felt.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "framework/core/check.hpp"
#include "framework/core/perception.hpp"
#include "framework/core/third_octaves.hpp"

namespace tactor {

namespace {

constexpr double window_s = 0.5;
constexpr double least_dB = -100;

/// The mean of all, and the largest of windows of `window` samples, which follow each other by half a window; the last
/// one ends with the samples.
struct MeanAndLargest {
  double mean = 0;
  double largest = 0;
};

MeanAndLargest mean_and_largest(std::span<const double> x, std::size_t window) {
  std::vector<double> sums{0};  // of the first i
  sums.reserve(x.size() + 1);
  for (const double v : x) sums.push_back(sums.back() + v);
  const auto mean_of = [&](std::size_t begin) {
    return (sums[begin + window] - sums[begin]) / static_cast<double>(window);
  };
  MeanAndLargest found{sums.back() / static_cast<double>(x.size()), mean_of(x.size() - window)};
  const std::size_t hop = std::max<std::size_t>(1, window / 2);
  for (std::size_t begin = 0; begin + window <= x.size(); begin += hop) {
    found.largest = std::max(found.largest, mean_of(begin));
  }
  return found;
}

double level_dB(double mean_square, double threshold) {
  return std::max(least_dB, 10 * std::log10(mean_square / (threshold * threshold)));
}

}  // namespace

double share_beyond_weber(std::span<const Vec3> x, std::span<const Vec3> reference) {
  TACTOR_DEMAND(x.size() == reference.size());
  if (x.empty()) return 0;
  std::size_t beyond = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (!(norm(x[i] - reference[i]) <= force_jnd(norm(reference[i])))) ++beyond;
  }
  return static_cast<double>(beyond) / static_cast<double>(x.size());
}

std::optional<FeltVibration> felt_vibration(std::span<const Vec3> x, std::span<const Vec3> reference, double rate_Hz,
                                            double handle_mass) {
  TACTOR_DEMAND(x.size() == reference.size());
  const auto window = static_cast<std::size_t>(std::llround(window_s * rate_Hz));
  const std::vector<ThirdOctave> bands = third_octaves(rate_Hz);
  if (window == 0 || x.size() < window || bands.empty()) return std::nullopt;
  std::vector<Vec3> error(x.begin(), x.end());
  for (std::size_t i = 0; i < error.size(); ++i) error[i] -= reference[i];

  FeltVibration found{least_dB, 0, least_dB};
  for (const ThirdOctave& band : bands) {
    const double threshold = vibration_force_threshold(band.centre_Hz, handle_mass);
    const MeanAndLargest square = mean_and_largest(band_squares(error, band, rate_Hz), window);
    if (!std::isfinite(square.mean)) return std::nullopt;
    const double mean = level_dB(square.mean, threshold);
    if (mean > found.mean_dB) {
      found.mean_dB = mean;
      found.mean_Hz = band.nominal_Hz;
    }
    found.worst_dB = std::max(found.worst_dB, level_dB(square.largest, threshold));
  }
  return found;
}

}  // namespace tactor
