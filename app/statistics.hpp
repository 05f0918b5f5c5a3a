// Tests of whether two pipelines differ: the paper's one-way ANOVA, and the paired difference over seeds.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

namespace tactor {

/// Middle of the sorted values (mean of the two middle ones where their number is even). NaN for none.
double median(std::span<const double> values);
/// The value below which the share `q` in [0, 1] lies, linearly interpolated between order statistics. NaN for none.
double quantile(std::span<const double> values, double q);
double mean(std::span<const double> values);
/// Sample standard deviation (divisor n - 1); 0 for fewer than two.
double standard_deviation(std::span<const double> values);

/// One-way analysis of variance between two groups of samples.
struct Anova {
  double F = 0;
  double p = 1;
  double df_between = 1;
  double df_within = 0;
};
/// Absent where a group has fewer than two values or nothing varies within the groups.
/// The test takes its samples for independent; samples of a time series are not, see PairedDifference.
std::optional<Anova> one_way_anova(std::span<const double> a, std::span<const double> b);

/// The difference b - a over pairs (one pair a seed).
struct PairedDifference {
  std::size_t pairs = 0;
  double mean = 0;
  double low = 0;  ///< 95 % confidence interval of the mean, Student t
  double high = 0;
  double effect_size = 0;  ///< Cohen's d of the differences: mean / standard deviation
  double p_wilcoxon = 1;   ///< signed-rank test, two-sided; exact up to 25 pairs without ties, else normal
};
/// Absent for fewer than two pairs.
std::optional<PairedDifference> paired_difference(std::span<const double> a, std::span<const double> b);

/// The geometric mean of ratios, and its 95 % confidence interval: that of the mean of their logarithms, Student t.
struct GeometricMean {
  std::size_t count = 0;
  double ratio = 1;
  double low = 0;  ///< NaN, as is `high`, where there is one ratio alone, which has no interval
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
