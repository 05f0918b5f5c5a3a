// Envelopes of long curves: no peak gets lost, and they stay small.
#include "app/run/envelope.hpp"

#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <limits>
#include <random>

BOOST_AUTO_TEST_SUITE(envelope_test)

using namespace tactor;

BOOST_AUTO_TEST_CASE(a_short_curve_stays_as_it_is) {
  Envelope envelope(5);
  BOOST_TEST(envelope.empty());
  const std::vector<double> times{0, 1, 2, 3, 4}, values{3, -1, 4, 1, 5};
  for (std::size_t i = 0; i < times.size(); ++i) envelope.add(times[i], values[i]);
  envelope.add(5, std::numeric_limits<double>::quiet_NaN());
  const Series series = envelope.series("s", "N");
  BOOST_TEST(series.name == "s");
  BOOST_TEST(series.unit == "N");
  BOOST_TEST(series.time == times);
  BOOST_TEST(series.value == values);
}

BOOST_AUTO_TEST_CASE(each_peak_of_a_long_curve_is_kept_and_all_that_is_kept_is_of_the_curve) {
  std::mt19937 draw(7);
  for (const int count : {6, 11, 100, 997, 20000}) {
    for (const std::size_t most : {std::size_t{2}, std::size_t{5}, std::size_t{64}}) {
      Envelope envelope(most);
      std::vector<double> values;
      for (int i = 0; i < count; ++i) {
        values.push_back(std::sin(0.01 * i) + 1e-3 * static_cast<double>(draw() % 1000));
        envelope.add(i, values.back());
      }
      const Series series = envelope.series("", "");
      BOOST_TEST(series.time.size() <= 2 * most);
      BOOST_TEST(std::is_sorted(series.time.begin(), series.time.end()));
      for (std::size_t i = 0; i < series.time.size(); ++i)
        BOOST_REQUIRE(series.value[i] == values[static_cast<std::size_t>(series.time[i])]);
      const auto [low, high] = std::minmax_element(values.begin(), values.end());
      const auto [kept_low, kept_high] = std::minmax_element(series.value.begin(), series.value.end());
      BOOST_TEST(*kept_low == *low);
      BOOST_TEST(*kept_high == *high);
      // Between two values that are kept, no value lies outside of what is kept near it.
      for (std::size_t i = 1; i + 1 < series.time.size(); ++i) {
        const auto begin = static_cast<std::size_t>(series.time[i - 1]), end = static_cast<std::size_t>(series.time[i]);
        const std::size_t first = i < 3 ? 0 : i - 3, last = std::min(series.value.size(), i + 3);
        const auto [near_low, near_high] =
            std::minmax_element(series.value.begin() + static_cast<std::ptrdiff_t>(first),
                                series.value.begin() + static_cast<std::ptrdiff_t>(last));
        for (std::size_t k = begin; k <= end; ++k) BOOST_REQUIRE((values[k] >= *near_low && values[k] <= *near_high));
      }
    }
  }
}

BOOST_AUTO_TEST_SUITE_END()
