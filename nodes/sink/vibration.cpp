#include "nodes/sink/vibration.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "framework/core/check.hpp"
#include "framework/core/perception.hpp"
#include "framework/core/third_octaves.hpp"
#include "nodes/sink/metrics.hpp"

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

void declare_felt_metrics(Declare<Metrics>& node) {
  const auto add = [&node](const char* name, const char* unit, const char* doc, Better better, const char* missing) {
    node.metric(std::string("delivered.force.") + name, unit, doc, better)
        .missing_where(missing)
        .left_out_when([](const Metrics::Params&, const MetricUse& use) {
          return use.reference ? std::string() : "no reference run is made";
        });
  };
  add("share_beyond_weber", "1", "share of the time in which the error is noticed at the reference's force",
      Better::lower, "fewer than three commands come in the judged interval");
  const char* const no_band = "less than 0.5 s is judged, or commands come slower than 25 Hz";
  add("vibration_above_threshold_dB", "dB", "vibration of the error over what is felt, highest band", Better::lower,
      no_band);
  add("vibration_above_threshold_Hz", "Hz", "centre of that band", Better::neither,
      "less than 0.5 s is judged, commands come slower than 25 Hz, or there is no vibration");
  add("worst_vibration_above_threshold_dB", "dB", "the same of the worst half second", Better::lower, no_band);
}

void report_felt(Report& report, std::span<const Vec3> x, std::span<const Vec3> reference, double rate_Hz,
                 double handle_mass) {
  const std::string delivered = "delivered.force.";
  report.set(delivered + "share_beyond_weber", share_beyond_weber(x, reference));
  const auto felt = felt_vibration(x, reference, rate_Hz, handle_mass);
  if (!felt) return;
  report.set(delivered + "vibration_above_threshold_dB", felt->mean_dB);
  if (felt->mean_Hz > 0) report.set(delivered + "vibration_above_threshold_Hz", felt->mean_Hz);
  report.set(delivered + "worst_vibration_above_threshold_dB", felt->worst_dB);
}

}  // namespace tactor
