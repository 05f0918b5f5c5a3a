// What is noticed of an error: on errors whose level over the threshold is known beforehand.
#include "framework/core/felt.hpp"

#include <boost/test/unit_test.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "framework/core/perception.hpp"

BOOST_AUTO_TEST_SUITE(felt_test)

using namespace tactor;

namespace {

constexpr double pi = std::numbers::pi;
constexpr double rate = 1000;
using Signal = std::vector<Vec3>;

/// A sinusoid along y from `begin` to `end` s, of 4 s.
Signal wave(double amplitude, double frequency, double begin = 0, double end = 4) {
  Signal x;
  for (int i = 0; i < 4000; ++i) {
    const double t = i / rate;
    x.push_back({0, t >= begin && t < end ? amplitude * std::sin(2 * pi * frequency * t) : 0.0, 0});
  }
  return x;
}

/// 2 N, slowly changing.
Signal reference() {
  Signal r;
  for (int i = 0; i < 4000; ++i) r.push_back({2 + 0.5 * std::sin(2 * pi * i / rate), 0, -1});
  return r;
}

Signal sum(Signal a, const Signal& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] += b[i];
  return a;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_sinusoid_has_its_level_over_the_threshold_of_its_band_on_every_handle) {
  const Signal r = reference();
  for (const double handle : {0.05, 0.1, 0.3}) {
    for (const double frequency : {20.0, 50.0, 100.0, 200.0}) {
      const double threshold = vibration_force_threshold(frequency, handle);
      const auto found = felt_vibration(sum(r, wave(0.2, frequency)), r, rate, handle);
      BOOST_REQUIRE(found.has_value());
      const double expected = 20 * std::log10(0.2 / std::sqrt(2.0) / threshold);
      // The nominal centre is up to 0.8 % off the centre, and the filter takes a while to begin.
      BOOST_TEST(std::abs(found->mean_dB - expected) < 0.3, frequency << " Hz: " << found->mean_dB << ", " << expected);
      BOOST_TEST(std::abs(found->worst_dB - expected) < 0.3);
      BOOST_TEST(found->mean_Hz == frequency);
    }
  }
}

BOOST_AUTO_TEST_CASE(half_a_second_of_vibration_in_four_is_9_dB_louder_at_its_worst_than_in_the_mean) {
  const Signal r = reference();
  const auto found = felt_vibration(sum(r, wave(0.2, 100, 2, 2.5)), r, rate, 0.1);
  BOOST_REQUIRE(found.has_value());
  // The filter's begin and end lie in the half second and after it.
  BOOST_TEST(std::abs(found->worst_dB - found->mean_dB - 10 * std::log10(8.0)) < 0.3);
}

BOOST_AUTO_TEST_CASE(of_two_waves_the_one_further_over_its_threshold_counts_and_not_the_larger) {
  const Signal r = reference();
  const auto found = felt_vibration(sum(sum(r, wave(0.1, 16)), wave(0.05, 160)), r, rate, 0.1);
  BOOST_REQUIRE(found.has_value());
  BOOST_TEST(found->mean_Hz == 160);
}

BOOST_AUTO_TEST_CASE(slow_errors_are_wrong_forces_and_no_vibration) {
  const Signal r = reference();
  const auto found = felt_vibration(sum(r, wave(1, 0.5)), r, rate, 0.1);
  BOOST_REQUIRE(found.has_value());
  BOOST_TEST(found->worst_dB < 0);
  BOOST_TEST(share_beyond_weber(sum(r, wave(1, 0.5)), r) > 0.8);
}

BOOST_AUTO_TEST_CASE(without_an_error_the_level_is_the_lowest_that_is_told_and_no_band_has_it) {
  const Signal r = reference();
  const auto found = felt_vibration(r, r, rate, 0.1);
  BOOST_REQUIRE(found.has_value());
  BOOST_TEST(found->mean_dB == -100);
  BOOST_TEST(found->worst_dB == -100);
  BOOST_TEST(found->mean_Hz == 0);
}

BOOST_AUTO_TEST_CASE(too_little_too_slow_or_not_finite_says_nothing) {
  const Signal r = reference();
  const std::span<const Vec3> all(r);
  BOOST_TEST(!felt_vibration(all.first(499), all.first(499), rate, 0.1).has_value());
  BOOST_TEST(felt_vibration(all.first(500), all.first(500), rate, 0.1).has_value());
  BOOST_TEST(!felt_vibration(r, r, 24, 0.1).has_value());
  Signal broken = r;
  broken[2000].x = std::numeric_limits<double>::quiet_NaN();
  BOOST_TEST(!felt_vibration(broken, r, rate, 0.1).has_value());
}

BOOST_AUTO_TEST_CASE(the_share_beyond_the_curve_is_judged_at_the_references_own_force) {
  // 0.1 N too much is noticed at 0 N and at 0.3 N (0.08 N), and is not at 1 N (0.126 N) and at 10 N (0.7 N).
  const Signal r{{0, 0, 0}, {0.3, 0, 0}, {0, 1, 0}, {0, 0, 10}};
  Signal x = r;
  for (Vec3& v : x) v.x += 0.1;
  BOOST_TEST(share_beyond_weber(x, r) == 0.5);
  for (Vec3& v : x) v.x += 0.03;
  BOOST_TEST(share_beyond_weber(x, r) == 0.75);
  BOOST_TEST(share_beyond_weber(r, r) == 0.0);
  Signal broken = r;
  broken[0].y = std::numeric_limits<double>::quiet_NaN();
  BOOST_TEST(share_beyond_weber(broken, r) == 0.25);
  BOOST_TEST(share_beyond_weber(r, broken) == 0.25);
  BOOST_TEST(share_beyond_weber(Signal(), Signal()) == 0.0);
}

BOOST_AUTO_TEST_SUITE_END()
