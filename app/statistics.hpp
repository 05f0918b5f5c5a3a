// Tests of whether two pipelines differ: the paper's one-way ANOVA, and the paired difference over seeds.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace tactor {

/// Middle of the sorted values (mean of the two middle ones where their number is even). NaN for none.
double median(std::span<const double> values);
/// The value below which the share `q` in [0, 1] lies, linearly interpolated between order statistics. NaN for none.
double quantile(std::span<const double> values, double q);
double mean(std::span<const double> values);
/// Sample standard deviation (divisor n - 1); 0 for fewer than two, and for equal ones.
double standard_deviation(std::span<const double> values);

/// One-way analysis of variance between two groups of samples.
struct Anova {
  double F = 0;
  double p = 1;
  double df_between = 1;
  double df_within = 0;
};
/// Absent where a group has fewer than two values, or where nothing varies within the groups beyond rounding.
/// The test takes its samples for independent; samples of a time series are not, see PairedDifference.
std::optional<Anova> one_way_anova(std::span<const double> a, std::span<const double> b);

/// How the pairs of two groups are alike, so that they say nothing of chance.
enum class Identical : std::uint8_t {
  no,
  groups,  ///< b equals a in every pair, to rounding
  pairs,   ///< all pairs are copies of one: no group varies beyond rounding
};

/// A 95 % confidence interval.
struct Interval {
  double low = 0;
  double high = 0;
};

/// The fewest seeds of which intervals, effect sizes and tests are told: of fewer, chance alone makes large effects,
/// and no p of Wilcoxon's is below .05.
inline constexpr std::size_t fewest_seeds = 6;

/// The difference b - a over pairs (one pair a seed). Of fewer than `fewest_seeds` pairs the mean alone is told.
struct PairedDifference {
  std::size_t pairs = 0;
  Identical identical = Identical::no;
  double mean = 0;
  std::optional<Interval> interval;  ///< of the mean, Student t; absent where the differences have no spread
  /// Cohen's d_z, mean / standard deviation; absent without spread.
  std::optional<double> effect_size;
  /// Signed-rank test of Wilcoxon, two-sided. Zero differences are left out (Wilcoxon's own way), equal sizes share
  /// their mean rank. Counted over all sign patterns, which is exact with ties too, up to 200 pairs; above by the
  /// normal distribution. Absent for identical ones.
  std::optional<double> p_wilcoxon;
};
/// Absent for fewer than two pairs, and where a value is not finite.
std::optional<PairedDifference> paired_difference(std::span<const double> a, std::span<const double> b);

/// The geometric mean of ratios, and its 95 % confidence interval: that of the mean of their logarithms, Student t.
struct GeometricMean {
  std::size_t count = 0;
  double ratio = 1;
  double low = 0;  ///< NaN, as is `high`, for fewer than `fewest_seeds`, and where the ratios are copies of one
  double high = 0;
};
/// Of the ratios exp(logs_i). Absent for none, or where one is not finite.
std::optional<GeometricMean> geometric_mean(std::span<const double> logs);

/// Values that fall into two groups with nothing between them.
struct TwoPopulations {
  std::size_t low_count = 0, high_count = 0;
  double low_min = 0, low_max = 0, high_min = 0, high_max = 0;
};
/// The two groups on either side of the widest gap between sorted values. Nothing for fewer than eight values, where
/// the gap is not twice as wide as either group, where a group has fewer than two values, or where the groups are less
/// than a quarter apart (high_min < 1.25 low_max). Values are above zero and compared by their logarithms, so that
/// their unit does not matter; else nothing. Of values drawn from one normal distribution about 1 in 100 sets of 8, 1
/// in 500 of 10 and fewer than 1 in 1,000 of 12 and more are said to be two.
std::optional<TwoPopulations> two_populations(std::span<const double> values);

}  // namespace tactor
