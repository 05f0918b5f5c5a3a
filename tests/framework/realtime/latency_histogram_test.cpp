// Quantiles agree with sorted samples, extremes are kept, and reading while writing is safe.
#include "framework/realtime/latency_histogram.hpp"

#include <algorithm>
#include <atomic>
#include <boost/random/lognormal_distribution.hpp>
#include <boost/random/mersenne_twister.hpp>
#include <boost/random/uniform_int_distribution.hpp>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <thread>
#include <vector>

BOOST_AUTO_TEST_SUITE(latency_histogram_test)

using namespace tactor;

namespace {

/// The nearest-rank quantile of sorted samples, by its definition.
std::int64_t sorted_quantile(const std::vector<std::int64_t>& sorted, double q) {
  const auto rank = static_cast<std::size_t>(std::ceil(q * static_cast<double>(sorted.size())));
  return sorted[std::max<std::size_t>(rank, 1) - 1];
}

void check_against_sorted(std::vector<std::int64_t> samples) {
  LatencyHistogram histogram;
  for (const std::int64_t ns : samples) histogram.record({ns});
  std::sort(samples.begin(), samples.end());
  BOOST_TEST(histogram.count() == samples.size());
  BOOST_TEST(histogram.max().ns == samples.back());
  for (const double q : {0.0, 0.001, 0.1, 0.25, 0.5, 0.75, 0.9, 0.99, 0.999, 0.9999, 1.0}) {
    const std::int64_t expected = sorted_quantile(samples, q);
    const double error = std::abs(static_cast<double>(histogram.quantile(q).ns - expected));
    BOOST_TEST(error <= 0.008 * static_cast<double>(expected),
               "q = " << q << ", expected " << expected << ", found " << histogram.quantile(q).ns);
  }
}

}  // namespace

BOOST_AUTO_TEST_CASE(an_empty_histogram_is_all_zero) {
  const LatencyHistogram histogram;
  BOOST_TEST(histogram.count() == 0U);
  BOOST_TEST(histogram.max().ns == 0);
  BOOST_TEST(histogram.quantile(0.5).ns == 0);
  BOOST_TEST(histogram.quantile(1).ns == 0);
}

BOOST_AUTO_TEST_CASE(one_value_is_told_within_eight_in_a_thousand_over_the_whole_range) {
  for (double value = 1; value <= 1e11; value *= 1.0371) {
    LatencyHistogram histogram;
    const auto ns = static_cast<std::int64_t>(value);
    histogram.record({ns});
    BOOST_TEST(histogram.quantile(1).ns == ns);
    BOOST_TEST(std::abs(static_cast<double>(histogram.quantile(0.5).ns - ns)) <= 0.008 * value);
    if (ns < 128) BOOST_TEST(histogram.quantile(0.5).ns == ns);
  }
}

BOOST_AUTO_TEST_CASE(quantiles_agree_with_sorted_samples) {
  boost::random::mt19937_64 generator(7);
  boost::random::lognormal_distribution<double> latency(std::log(11e3), 0.8);
  boost::random::uniform_int_distribution<std::int64_t> uniform(1, 100'000'000'000);
  std::vector<std::int64_t> samples(20'000);
  for (auto& ns : samples) ns = std::max<std::int64_t>(1, static_cast<std::int64_t>(latency(generator)));
  check_against_sorted(samples);
  for (auto& ns : samples) ns = uniform(generator);
  check_against_sorted(samples);
  check_against_sorted({5, 1'000'000});
  check_against_sorted(std::vector<std::int64_t>(1000, 51'234));
}

BOOST_AUTO_TEST_CASE(what_is_out_of_range_is_clamped_and_the_maximum_stays_exact) {
  LatencyHistogram histogram;
  histogram.record({-50});
  BOOST_TEST(histogram.max().ns == -50);
  BOOST_TEST(histogram.quantile(0.5).ns == 1);
  histogram.record({0});
  BOOST_TEST(histogram.max().ns == 0);
  const std::int64_t hour = 3'600'000'000'000;
  histogram.record({hour});
  histogram.record({hour + 1});
  BOOST_TEST(histogram.count() == 4U);
  BOOST_TEST(histogram.max().ns == hour + 1);
  BOOST_TEST(histogram.quantile(1).ns == hour + 1);
  BOOST_TEST(std::abs(histogram.quantile(0.75).seconds() - 100) <= 0.8);
}

BOOST_AUTO_TEST_CASE(merging_counts_both) {
  std::vector<std::int64_t> samples;
  LatencyHistogram left;
  LatencyHistogram right;
  for (std::int64_t ns = 1; ns <= 2000; ++ns) {
    samples.push_back(37 * ns);
    (ns % 3 == 0 ? left : right).record({37 * ns});
  }
  LatencyHistogram sum = left;
  sum.merge(right);
  sum.merge(LatencyHistogram());
  BOOST_TEST(left.count() + right.count() == 2000U);
  BOOST_TEST(sum.count() == 2000U);
  BOOST_TEST(sum.max().ns == 74'000);
  for (const double q : {0.01, 0.5, 0.99}) {
    const auto expected = static_cast<double>(sorted_quantile(samples, q));
    BOOST_TEST(std::abs(static_cast<double>(sum.quantile(q).ns) - expected) <= 0.008 * expected);
  }
}

BOOST_AUTO_TEST_CASE(counts_tell_every_bucket_that_is_not_empty_in_order) {
  LatencyHistogram histogram;
  BOOST_TEST(histogram.counts().empty());
  for (const std::int64_t ns : {100'000, 7, 100'000, 7, 7, 90}) histogram.record({ns});
  const auto counts = histogram.counts();
  BOOST_REQUIRE(counts.size() == 3U);
  BOOST_TEST(counts[0].first.ns == 7);
  BOOST_TEST(counts[0].second == 3U);
  BOOST_TEST(counts[1].first.ns == 90);
  BOOST_TEST(counts[1].second == 1U);
  // Within half a bucket, which is 1/64 of its values wide.
  BOOST_TEST(std::abs(static_cast<double>(counts[2].first.ns) - 100'000) <= 100'000.0 / 128);
  BOOST_TEST(counts[2].second == 2U);
}

BOOST_AUTO_TEST_CASE(a_reader_sees_sound_figures_while_the_writer_writes) {
  LatencyHistogram histogram;
  std::atomic<bool> done{false};
  constexpr std::int64_t writes = 200'000;
  std::thread writer([&] {
    for (std::int64_t i = 0; i < writes; ++i) histogram.record({1000 + i % 1000});
    done.store(true, std::memory_order_release);
  });
  std::uint64_t last = 0;
  int unsound = 0;
  while (!done.load(std::memory_order_acquire)) {
    const std::uint64_t count = histogram.count();
    const std::int64_t median = histogram.quantile(0.5).ns;
    const bool plausible = count == 0 || (median >= 990 && median <= 2010);
    unsound += count >= last && plausible && histogram.max().ns < 2000 ? 0 : 1;
    last = count;
  }
  writer.join();
  BOOST_TEST(unsound == 0);
  BOOST_TEST(histogram.count() == static_cast<std::uint64_t>(writes));
  BOOST_TEST(std::abs(static_cast<double>(histogram.quantile(0.5).ns) - 1499) <= 0.008 * 1499);
}

BOOST_AUTO_TEST_SUITE_END()
