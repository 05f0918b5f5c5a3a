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

/// What sums of thousands of terms lose, relative to their size; no metric resolves as little.
constexpr double relative_rounding = 1e-12;

/// True where the values differ by more than the rounding of numbers of the size `scale`.
bool has_spread(std::span<const double> values, double scale) {
  if (values.size() < 2) return false;
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return *high - *low > relative_rounding * scale;
}

double largest_size(std::span<const double> values) {
  double size = 0;
  for (const double v : values) size = std::max(size, std::abs(v));
  return size;
}

/// Half of the 95 % confidence interval of the mean, for two values and more.
double half_interval(std::span<const double> values) {
  const auto n = static_cast<double>(values.size());
  return boost::math::quantile(StudentsT(n - 1), 0.975) * standard_deviation(values) / std::sqrt(n);
}

/// Non-zero differences, ranked by size; equal sizes share their mean rank.
struct SignedRanks {
  std::vector<std::size_t> twice;  ///< twice the rank of each, a whole number
  std::size_t twice_positive = 0;  ///< twice the sum of the ranks of those above zero
};

SignedRanks signed_ranks(std::vector<double> differences) {
  std::erase(differences, 0.0);
  std::sort(differences.begin(), differences.end(), [](double a, double b) { return std::abs(a) < std::abs(b); });
  SignedRanks ranks;
  const std::size_t n = differences.size();
  for (std::size_t i = 0; i < n;) {
    std::size_t j = i;
    while (j < n && std::abs(differences[j]) == std::abs(differences[i])) ++j;
    for (std::size_t k = i; k < j; ++k) {
      ranks.twice.push_back(i + 1 + j);
      if (differences[k] > 0) ranks.twice_positive += i + 1 + j;
    }
    i = j;
  }
  return ranks;
}

/// Two-sided p of the Wilcoxon signed-rank test; 1 for no ranks.
double signed_rank_p(const SignedRanks& ranks) {
  constexpr std::size_t most_exact = 200;
  const std::size_t total = std::accumulate(ranks.twice.begin(), ranks.twice.end(), std::size_t{0});
  const std::size_t smaller = std::min(ranks.twice_positive, total - ranks.twice_positive);
  if (ranks.twice.size() <= most_exact) {
    // The chance of each sum when every sign is tossed, by adding one rank at a time.
    std::vector<double> chance(total + 1, 0.0);
    chance[0] = 1;
    std::size_t reach = 0;
    for (const std::size_t rank : ranks.twice) {
      for (std::size_t sum = 0; sum <= reach; ++sum) chance[sum] *= 0.5;
      for (std::size_t sum = reach + 1; sum-- > 0;) chance[sum + rank] += chance[sum];
      reach += rank;
    }
    const auto end = chance.begin() + static_cast<std::ptrdiff_t>(smaller + 1);
    return std::min(1.0, 2.0 * std::accumulate(chance.begin(), end, 0.0));
  }
  double variance = 0;  // of twice the sum
  for (const std::size_t rank : ranks.twice) variance += 0.25 * static_cast<double>(rank) * static_cast<double>(rank);
  const double below = static_cast<double>(smaller) - 0.5 * static_cast<double>(total) + 1;
  return std::min(1.0, 2.0 * boost::math::cdf(Normal(), below / std::sqrt(variance)));
}

/// How pairs of values of the size `scale` are alike.
Identical how_identical(std::span<const double> a, std::span<const double> b, double scale) {
  const auto equal = [scale](double x, double y) { return std::abs(y - x) <= relative_rounding * scale; };
  if (std::equal(a.begin(), a.end(), b.begin(), equal)) return Identical::groups;
  return has_spread(a, scale) || has_spread(b, scale) ? Identical::no : Identical::pairs;
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
  // The mean of equal values may be rounded, which is no deviation.
  if (!has_spread(values, 0)) return 0;
  return std::sqrt(square_sum_about(values, mean(values)) / static_cast<double>(values.size() - 1));
}

std::optional<Anova> one_way_anova(std::span<const double> a, std::span<const double> b) {
  if (a.size() < 2 || b.size() < 2) return std::nullopt;
  const double mean_a = mean(a);
  const double mean_b = mean(b);
  const auto n_a = static_cast<double>(a.size());
  const auto n_b = static_cast<double>(b.size());
  const double grand = (n_a * mean_a + n_b * mean_b) / (n_a + n_b);
  const double size = std::max(largest_size(a), largest_size(b));
  if (!has_spread(a, size) && !has_spread(b, size)) return std::nullopt;
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
  // A ratio has a rounding of its own, whatever it is.
  const bool is_told = logs.size() >= fewest_seeds && has_spread(logs, 1 + largest_size(logs));
  const double half = is_told ? half_interval(logs) : std::nan("");
  return GeometricMean{logs.size(), std::exp(centre), std::exp(centre - half), std::exp(centre + half)};
}

std::optional<PairedDifference> paired_difference(std::span<const double> a, std::span<const double> b) {
  TACTOR_DEMAND(a.size() == b.size());
  if (a.size() < 2) return std::nullopt;
  std::vector<double> differences(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) differences[i] = b[i] - a[i];
  if (!std::all_of(differences.begin(), differences.end(), [](double d) { return std::isfinite(d); })) {
    return std::nullopt;
  }
  PairedDifference result;
  result.pairs = a.size();
  const double scale = std::max(largest_size(a), largest_size(b));
  result.identical = how_identical(a, b, scale);
  result.mean = mean(differences);
  if (result.identical != Identical::no || result.pairs < fewest_seeds) return result;
  if (has_spread(differences, scale)) {
    const double half = half_interval(differences);
    result.interval = Interval{result.mean - half, result.mean + half};
    result.effect_size = result.mean / standard_deviation(differences);
  }
  result.p_wilcoxon = signed_rank_p(signed_ranks(std::move(differences)));
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
