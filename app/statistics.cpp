#include "app/statistics.hpp"

#include <algorithm>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

/// Boost computes in long double otherwise, by instructions of the processor whose last digits its makers do not agree
/// on.
using InDouble = boost::math::policies::policy<boost::math::policies::promote_double<false>>;
using StudentsT = boost::math::students_t_distribution<double, InDouble>;
using Normal = boost::math::normal_distribution<double, InDouble>;
using FisherF = boost::math::fisher_f_distribution<double, InDouble>;

double square_sum_about(std::span<const double> values, double centre) {
  double sum = 0;
  for (const double v : values) sum += (v - centre) * (v - centre);
  return sum;
}

/// Half of the 95 % confidence interval of the mean, for two values and more.
double half_interval(std::span<const double> values) {
  const auto n = static_cast<double>(values.size());
  return boost::math::quantile(StudentsT(n - 1), 0.975) * standard_deviation(values) / std::sqrt(n);
}

/// Two-sided p of the Wilcoxon signed-rank test over non-zero differences.
double signed_rank_p(std::vector<double> differences) {
  std::erase(differences, 0.0);
  const std::size_t n = differences.size();
  if (n == 0) return 1.0;
  std::sort(differences.begin(), differences.end(), [](double a, double b) { return std::abs(a) < std::abs(b); });
  double positive = 0;
  double tie_correction = 0;
  bool ties = false;
  for (std::size_t i = 0; i < n;) {
    std::size_t j = i;
    while (j < n && std::abs(differences[j]) == std::abs(differences[i])) ++j;
    const double rank = 0.5 * (static_cast<double>(i + 1) + static_cast<double>(j));
    const double count = static_cast<double>(j - i);
    ties = ties || j - i > 1;
    tie_correction += count * count * count - count;
    for (std::size_t k = i; k < j; ++k) {
      if (differences[k] > 0) positive += rank;
    }
    i = j;
  }
  const double total = 0.5 * static_cast<double>(n) * static_cast<double>(n + 1);
  const double smaller = std::min(positive, total - positive);
  if (!ties && n <= 25) {
    // The number of sign patterns for each rank sum, by adding one rank at a time.
    std::vector<double> ways(static_cast<std::size_t>(total) + 1, 0.0);
    ways[0] = 1;
    std::size_t reach = 0;
    for (std::size_t rank = 1; rank <= n; ++rank) {
      reach += rank;
      for (std::size_t sum = reach; sum >= rank; --sum) ways[sum] += ways[sum - rank];
    }
    double below = 0;
    for (std::size_t sum = 0; sum <= static_cast<std::size_t>(smaller); ++sum) below += ways[sum];
    return std::min(1.0, 2.0 * below / std::pow(2.0, static_cast<double>(n)));
  }
  const double m = static_cast<double>(n);
  const double variance = m * (m + 1) * (2 * m + 1) / 24.0 - tie_correction / 48.0;
  const double z = (smaller - 0.5 * total + 0.5) / std::sqrt(variance);
  return std::min(1.0, 2.0 * boost::math::cdf(Normal(), z));
}

}  // namespace

double median(std::span<const double> values) {
  return quantile(values, 0.5);
}

double quantile(std::span<const double> values, double q) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::vector<double> sorted(values.begin(), values.end());
  std::sort(sorted.begin(), sorted.end());
  const double position = q * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(position);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (position - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

double mean(std::span<const double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double standard_deviation(std::span<const double> values) {
  if (values.size() < 2) return 0;
  return std::sqrt(square_sum_about(values, mean(values)) / static_cast<double>(values.size() - 1));
}

std::optional<Anova> one_way_anova(std::span<const double> a, std::span<const double> b) {
  if (a.size() < 2 || b.size() < 2) return std::nullopt;
  const double mean_a = mean(a);
  const double mean_b = mean(b);
  const auto n_a = static_cast<double>(a.size());
  const auto n_b = static_cast<double>(b.size());
  const double grand = (n_a * mean_a + n_b * mean_b) / (n_a + n_b);
  const double between = n_a * (mean_a - grand) * (mean_a - grand) + n_b * (mean_b - grand) * (mean_b - grand);
  const double within = square_sum_about(a, mean_a) + square_sum_about(b, mean_b);
  Anova result;
  result.df_within = n_a + n_b - 2;
  if (!(within > 0)) return std::nullopt;
  result.F = between / (within / result.df_within);
  result.p = boost::math::cdf(boost::math::complement(FisherF(result.df_between, result.df_within), result.F));
  return result;
}

std::optional<GeometricMean> geometric_mean(std::span<const double> logs) {
  const double centre = mean(logs);
  if (!std::isfinite(centre)) return std::nullopt;
  const double half = logs.size() < 2 ? std::numeric_limits<double>::quiet_NaN() : half_interval(logs);
  return GeometricMean{logs.size(), std::exp(centre), std::exp(centre - half), std::exp(centre + half)};
}

std::optional<PairedDifference> paired_difference(std::span<const double> a, std::span<const double> b) {
  TACTOR_DEMAND(a.size() == b.size());
  if (a.size() < 2) return std::nullopt;
  std::vector<double> differences(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) differences[i] = b[i] - a[i];
  PairedDifference result;
  result.pairs = a.size();
  result.mean = mean(differences);
  const double sd = standard_deviation(differences);
  const double half = half_interval(differences);
  result.low = result.mean - half;
  result.high = result.mean + half;
  result.effect_size = sd > 0 ? result.mean / sd : 0.0;
  result.p_wilcoxon = signed_rank_p(differences);
  return result;
}

std::optional<TwoPopulations> two_populations(std::span<const double> values) {
  constexpr double least_ratio = 1.25;
  constexpr std::size_t least_count = 2, least_values = 8;
  constexpr double wider = 2;  // the gap than a group, as logarithms
  std::vector<double> sorted(values.begin(), values.end());
  if (sorted.size() < least_values) return std::nullopt;
  if (!std::all_of(sorted.begin(), sorted.end(), [](double v) { return std::isfinite(v) && v > 0; })) {
    return std::nullopt;
  }
  std::sort(sorted.begin(), sorted.end());
  const auto ratio = [&](std::size_t low, std::size_t high) { return sorted[high] / sorted[low]; };
  std::size_t split = 1;  // the first value of the upper group
  for (std::size_t i = 2; i < sorted.size(); ++i) {
    if (ratio(i - 1, i) > ratio(split - 1, split)) split = i;
  }
  const std::size_t last = sorted.size() - 1;
  const double gap = ratio(split - 1, split);
  if (split < least_count || sorted.size() - split < least_count || gap < least_ratio) return std::nullopt;
  if (gap <= std::pow(std::max(ratio(0, split - 1), ratio(split, last)), wider)) return std::nullopt;
  return TwoPopulations{split, sorted.size() - split, sorted[0], sorted[split - 1], sorted[split], sorted[last]};
}

}  // namespace tactor
