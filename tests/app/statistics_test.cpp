// Statistics against brute force, against each other's closed relations and against published quantiles. A test beside
// this one has scipy compute them.
#include "app/statistics.hpp"

#include <algorithm>
#include <boost/random/mersenne_twister.hpp>
#include <boost/random/normal_distribution.hpp>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <numeric>
#include <set>
#include <vector>

BOOST_AUTO_TEST_SUITE(statistics_test)

using namespace tactor;

namespace {

std::vector<double> draw(std::size_t n, double mean, unsigned seed) {
  boost::random::mt19937_64 engine(seed);
  boost::random::normal_distribution<double> normal(mean, 1.0);
  std::vector<double> values(n);
  for (double& v : values) v = normal(engine);
  return values;
}

/// Two-sided tail of Student's t by the trapezoidal rule over its density.
double t_tail(double t, double df) {
  const double c = std::exp(std::lgamma(0.5 * (df + 1)) - std::lgamma(0.5 * df)) / std::sqrt(df * M_PI);
  const auto density = [&](double x) { return c * std::pow(1 + x * x / df, -0.5 * (df + 1)); };
  const int steps = 200000;
  double sum = 0.5 * (density(0) + density(t));
  for (int i = 1; i < steps; ++i) sum += density(t * i / steps);
  return 1.0 - 2.0 * sum * t / steps;
}

std::vector<double> nonzero_differences(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> d;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (b[i] != a[i]) d.push_back(b[i] - a[i]);
  }
  return d;
}

bool has_zeros(const std::vector<double>& a, const std::vector<double>& b) {
  return nonzero_differences(a, b).size() < a.size();
}

bool has_ties(const std::vector<double>& a, const std::vector<double>& b) {
  std::set<double> sizes;
  const std::vector<double> d = nonzero_differences(a, b);
  for (const double v : d) sizes.insert(std::abs(v));
  return sizes.size() < d.size();
}

/// Twice the chance of a sum of positive ranks as far out as that of b - a, over all signs of the differences.
double p_by_all_signs(const std::vector<double>& a, const std::vector<double>& b) {
  const std::vector<double> d = nonzero_differences(a, b);
  std::vector<double> ranks;
  for (const double v : d) {
    double rank = 0.5;
    for (const double other : d) rank += std::abs(other) < std::abs(v) ? 1 : std::abs(other) == std::abs(v) ? 0.5 : 0;
    ranks.push_back(rank);
  }
  double found = 0;
  for (std::size_t i = 0; i < d.size(); ++i) found += d[i] > 0 ? ranks[i] : 0;
  const unsigned patterns = 1U << d.size();
  unsigned below = 0, above = 0;
  for (unsigned pattern = 0; pattern < patterns; ++pattern) {
    double sum = 0;
    for (std::size_t i = 0; i < d.size(); ++i) sum += (pattern >> i & 1U) * ranks[i];
    below += sum <= found;
    above += sum >= found;
  }
  return std::min(1.0, 2.0 * std::min(below, above) / patterns);
}

}  // namespace

BOOST_AUTO_TEST_CASE(anova_of_two_groups_is_the_square_of_the_pooled_t_test) {
  const std::vector<double> a = draw(13, 0.0, 1);
  const std::vector<double> b = draw(9, 0.8, 2);
  const auto square_sum = [](const std::vector<double>& v) {
    const double m = mean(v);
    return std::accumulate(v.begin(), v.end(), 0.0, [m](double s, double x) { return s + (x - m) * (x - m); });
  };
  const double pooled = (square_sum(a) + square_sum(b)) / 20.0;
  const double t = (mean(b) - mean(a)) / std::sqrt(pooled * (1.0 / 13 + 1.0 / 9));
  const auto anova = one_way_anova(a, b);
  BOOST_REQUIRE(anova);
  BOOST_TEST(std::abs(anova->F - t * t) < 1e-12);
  BOOST_TEST(anova->df_within == 20.0);
  BOOST_TEST(std::abs(anova->p - t_tail(std::abs(t), 20.0)) < 1e-8);
}

BOOST_AUTO_TEST_CASE(the_papers_F_has_the_papers_p) {
  // F = 7.64 at p = .0057 belongs to about 2,500 degrees of freedom within: two groups that far apart give it.
  const std::size_t n = 1250;
  std::vector<double> a(n);
  std::vector<double> b(n);
  for (std::size_t i = 0; i < n; ++i) {
    a[i] = i % 2 == 0 ? 1.0 : -1.0;
    b[i] = a[i] + std::sqrt(7.64 * 2.0 / static_cast<double>(n));
  }
  const auto anova = one_way_anova(a, b);
  BOOST_REQUIRE(anova);
  BOOST_TEST(std::abs(anova->F - 7.64) < 0.01);
  BOOST_TEST(std::abs(anova->p - 0.0057) < 1e-4);
}

BOOST_AUTO_TEST_CASE(equal_groups_have_F_zero_and_constant_ones_have_none) {
  const std::vector<double> a = draw(50, 0.0, 3);
  const auto anova = one_way_anova(a, a);
  BOOST_REQUIRE(anova);
  BOOST_TEST(anova->F == 0.0);
  BOOST_TEST(anova->p == 1.0);
  const std::vector<double> constant(5, 2.0);
  BOOST_TEST(!one_way_anova(constant, constant));
  BOOST_TEST(!one_way_anova(a, std::vector<double>{1.0}));
}

BOOST_AUTO_TEST_CASE(a_geometric_mean_and_its_interval_are_those_of_the_logarithms) {
  std::vector<double> logs;
  for (int i = 0; i < 6; ++i) logs.push_back(i * std::log(2.0));
  const auto m = geometric_mean(logs);
  BOOST_REQUIRE(m);
  BOOST_TEST(std::abs(m->ratio - std::pow(2.0, 2.5)) < 1e-12);
  // t(0.975, 5) = 2.570582; the standard deviation of 0, 1, ... 5 is sqrt(3.5), over sqrt(6) values.
  BOOST_TEST(std::abs(std::log2(m->high) - 2.5 - 2.570582 * std::sqrt(3.5 / 6)) < 1e-5);
  BOOST_TEST(std::abs(std::log2(m->low * m->high) - 5) < 1e-12);
  // Few values have no interval.
  while (logs.size() > 1) {
    logs.pop_back();
    const auto few = geometric_mean(logs);
    BOOST_TEST(std::abs(std::log2(few->ratio) - 0.5 * static_cast<double>(logs.size() - 1)) < 1e-12);
    BOOST_TEST(std::isnan(few->low));
    BOOST_TEST(std::isnan(few->high));
  }
  BOOST_TEST(!geometric_mean({}));
  BOOST_TEST(!geometric_mean(std::vector<double>{0.0, std::log(0.0)}));
}

BOOST_AUTO_TEST_CASE(signed_rank_p_is_the_count_over_all_sign_patterns) {
  const std::vector<double> d{0.3, -0.1, 1.7, 0.9, -0.45, 2.2, 0.65, 1.1};
  // Ranks by size: 0.1 0.3 0.45 0.65 0.9 1.1 1.7 2.2, of which 1 and 3 are negative: the smaller sum is 4.
  int extreme = 0;
  for (int pattern = 0; pattern < 256; ++pattern) {
    int sum = 0;
    for (int rank = 1; rank <= 8; ++rank) sum += (pattern >> (rank - 1) & 1) * rank;
    if (sum <= 4 || sum >= 36 - 4) ++extreme;
  }
  const std::vector<double> zero(d.size(), 0.0);
  const auto paired = paired_difference(zero, d);
  BOOST_REQUIRE(paired);
  BOOST_TEST(std::abs(paired->p_wilcoxon.value() - extreme / 256.0) < 1e-12);
}

BOOST_AUTO_TEST_CASE(signed_rank_p_is_that_count_with_ties_and_zeros_too_and_never_below_the_least_possible) {
  boost::random::mt19937_64 engine(52);
  int with_ties = 0, with_zeros = 0;
  for (int table = 0; table < 2000; ++table) {
    const std::size_t n = fewest_seeds + engine() % 6;
    const auto most = static_cast<std::int64_t>(1 + engine() % 6);
    std::vector<double> a(n), b(n);
    for (std::size_t i = 0; i < n; ++i) {
      a[i] = 100 + static_cast<double>(i);  // exact sums, so that equal sizes are ties
      b[i] = a[i] + static_cast<double>(static_cast<std::int64_t>(engine() % (2 * most + 1)) - most);
    }
    const auto paired = paired_difference(a, b);
    BOOST_REQUIRE(paired);
    const double p = p_by_all_signs(a, b);
    with_ties += has_ties(a, b);
    with_zeros += has_zeros(a, b);
    if (paired->identical == Identical::groups) {
      BOOST_TEST(!paired->p_wilcoxon);
      continue;
    }
    BOOST_REQUIRE(paired->p_wilcoxon);
    BOOST_TEST(std::abs(*paired->p_wilcoxon - p) < 1e-12);
    BOOST_TEST(*paired->p_wilcoxon >= std::ldexp(2.0, -static_cast<int>(n)));
    BOOST_TEST(paired->effect_size.has_value() == paired->interval.has_value());
  }
  BOOST_TEST(with_ties > 1000);
  BOOST_TEST(with_zeros > 500);
}

BOOST_AUTO_TEST_CASE(pairs_that_are_copies_of_one_tell_a_mean_alone) {
  // The mean of such differences is rounded, so that a standard deviation by the formula is 1e-17 and not 0.
  const std::vector<double> a(6, 0.1), b(6, 0.1 + 0.0717);
  const auto pairs = paired_difference(a, b);
  BOOST_REQUIRE(pairs);
  BOOST_TEST((pairs->identical == Identical::pairs));
  BOOST_TEST(std::abs(pairs->mean - 0.0717) < 1e-15);
  const std::vector<double> varies = draw(8, 0.0, 4);
  const auto groups = paired_difference(varies, varies);
  BOOST_TEST((groups->identical == Identical::groups));
  // Rounding makes no difference.
  std::vector<double> rounded = varies;
  for (double& v : rounded) v *= 1 + 1e-15;
  const auto nearly = paired_difference(varies, rounded);
  BOOST_TEST((nearly->identical == Identical::groups));
  for (const auto& found : {pairs, groups, nearly}) {
    BOOST_TEST(!found->interval);
    BOOST_TEST(!found->effect_size);
    BOOST_TEST(!found->p_wilcoxon);
  }
  for (const double v : {0.1, 0.3, 1e-9, 7e8}) {
    BOOST_TEST(standard_deviation(std::vector<double>(7, v)) == 0.0);
    BOOST_TEST(!one_way_anova(std::vector<double>(7, v), std::vector<double>(7, 2 * v)));
    const auto ratio = geometric_mean(std::vector<double>(7, std::log(v)));
    BOOST_TEST(std::abs(ratio->ratio / v - 1) < 1e-12);
    BOOST_TEST(std::isnan(ratio->low));
  }
}

BOOST_AUTO_TEST_CASE(equal_differences_of_groups_that_vary_have_a_p_and_no_effect_size) {
  const std::vector<double> a{1, 2, 3, 4, 5, 6};
  std::vector<double> b = a;
  for (double& v : b) v += 0.5;
  const auto paired = paired_difference(a, b);
  BOOST_REQUIRE(paired);
  BOOST_TEST((paired->identical == Identical::no));
  BOOST_TEST(!paired->effect_size);
  BOOST_TEST(!paired->interval);
  BOOST_TEST(paired->p_wilcoxon.value() == 2.0 / 64);
}

BOOST_AUTO_TEST_CASE(a_test_needs_six_pairs) {
  for (std::size_t n = 2; n <= 8; ++n) {
    const std::vector<double> zero(n, 0.0), d = draw(n, 1.0, 9);
    const auto paired = paired_difference(zero, d);
    BOOST_TEST(paired->effect_size.has_value() == (n >= 6));
    BOOST_TEST(paired->interval.has_value() == (n >= 6));
    BOOST_TEST(paired->p_wilcoxon.has_value() == (n >= 6));
    if (paired->effect_size) BOOST_TEST(std::abs(*paired->effect_size - mean(d) / standard_deviation(d)) < 1e-12);
  }
}

BOOST_AUTO_TEST_CASE(a_value_that_is_not_finite_makes_no_difference_of_means) {
  const std::vector<double> a(6, 1.0);
  for (const double bad : {std::nan(""), HUGE_VAL}) {
    const std::vector<double> b{1, 2, bad, 4, 5, 6};
    BOOST_TEST(!paired_difference(a, b));
    BOOST_TEST(!one_way_anova(a, b));
    BOOST_TEST(!geometric_mean(b));
  }
}

BOOST_AUTO_TEST_CASE(the_confidence_interval_uses_students_t) {
  const std::vector<double> a{1, 2, 3, 4, 5, 6};
  const std::vector<double> b{2, 4, 3, 6, 5, 7};
  // Differences 1 2 0 2 0 1: mean 1, standard deviation sqrt(0.8); t(0.975, 5) = 2.570582 from published tables.
  const auto paired = paired_difference(a, b);
  BOOST_REQUIRE(paired);
  BOOST_TEST(std::abs(paired->mean - 1.0) < 1e-15);
  BOOST_REQUIRE(paired->interval);
  BOOST_TEST(std::abs(paired->interval->high - (1.0 + 2.570582 * std::sqrt(0.8 / 6))) < 1e-6);
  BOOST_TEST(std::abs(paired->interval->low - (1.0 - 2.570582 * std::sqrt(0.8 / 6))) < 1e-6);
}

BOOST_AUTO_TEST_CASE(the_normal_approximation_continues_the_exact_test) {
  // 201 pairs are too many to be counted; without the smallest, whose rank is 1, they are counted.
  for (const bool tied : {false, true}) {
    std::vector<double> d = draw(201, 0.1, 5);
    for (double& v : d) v = tied ? std::round(4 * v) + 0.5 : v;
    std::swap(d.back(),
              *std::min_element(d.begin(), d.end(), [](double x, double y) { return std::abs(x) < std::abs(y); }));
    const std::vector<double> zero(d.size(), 0.0);
    const double approximate = paired_difference(zero, d)->p_wilcoxon.value();
    d.pop_back();
    const double exact = paired_difference(std::vector<double>(200, 0.0), d)->p_wilcoxon.value();
    BOOST_TEST(exact != approximate);
    BOOST_TEST(std::abs(exact - approximate) < 0.01);
  }
}

BOOST_AUTO_TEST_CASE(quantiles_interpolate_between_order_statistics) {
  const std::vector<double> v{4, 1, 3, 2};
  BOOST_TEST(median(v) == 2.5);
  BOOST_TEST(quantile(v, 0.0) == 1.0);
  BOOST_TEST(quantile(v, 1.0) == 4.0);
  BOOST_TEST(std::abs(quantile(v, 0.25) - 1.75) < 1e-15);
  BOOST_TEST(std::isnan(median(std::vector<double>{})));
}

BOOST_AUTO_TEST_CASE(values_with_a_gap_wider_than_either_group_are_two_populations) {
  // Two seeds in ten lie apart, as a peg that finds its hole or does not.
  const std::vector<double> peg{0.24, 0.69, 0.28, 0.31, 0.26, 0.34, 0.30, 0.69, 0.27, 0.25};
  const auto found = two_populations(peg);
  BOOST_REQUIRE(found.has_value());
  BOOST_TEST(found->low_count == 8);
  BOOST_TEST(found->high_count == 2);
  BOOST_TEST(found->low_min == 0.24);
  BOOST_TEST(found->low_max == 0.34);
  BOOST_TEST(found->high_min == 0.69);
  BOOST_TEST(found->high_max == 0.69);
  // The unit does not matter.
  std::vector<double> in_mN = peg;
  for (double& v : in_mN) v *= 1e3;
  BOOST_TEST(two_populations(in_mN)->low_count == 8);
}

BOOST_AUTO_TEST_CASE(one_population_is_not_split) {
  BOOST_TEST(!two_populations(std::vector<double>{}).has_value());
  // Too few to tell.
  BOOST_TEST(!two_populations(std::vector<double>{0.2, 0.2, 0.2, 0.9, 0.9, 0.9}).has_value());
  // One seed alone is an outlier, which the worst seed shows.
  BOOST_TEST(!two_populations(std::vector<double>{0.2, 0.21, 0.22, 0.23, 0.2, 0.21, 0.22, 0.9}).has_value());
  // Two groups that hardly differ are one.
  BOOST_TEST(!two_populations(std::vector<double>{1.0, 1.0, 1.001, 1.001, 1.1, 1.1, 1.101, 1.101}).has_value());
  BOOST_TEST(!two_populations(std::vector<double>{0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0}).has_value());
  BOOST_TEST(!two_populations(std::vector<double>{-1.0, 0.2, 1.0, std::nan(""), 1.0, 1.0, 1.0, 1.0}).has_value());
  // As seldom as is claimed, of draws whose logarithm is normal, however wide that is.
  const auto split = [](std::size_t count, double width) {
    constexpr int sets = 4000;
    int found = 0;
    for (unsigned seed = 1; seed <= sets; ++seed) {
      std::vector<double> values = draw(count, 0.0, seed);
      for (double& v : values) v = std::exp(width * v);
      found += two_populations(values).has_value();
    }
    return static_cast<double>(found) / sets;
  };
  for (const double width : {0.1, 0.5, 1.0}) {
    BOOST_TEST(split(8, width) < 0.013);
    BOOST_TEST(split(10, width) < 0.004);
    BOOST_TEST(split(12, width) < 0.001);
    BOOST_TEST(split(20, width) < 0.001);
  }
}

BOOST_AUTO_TEST_SUITE_END()
