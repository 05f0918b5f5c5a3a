// The error and delay of one force against another against closed forms.
#include "framework/session/running_error.hpp"

#include <boost/test/unit_test.hpp>
#include <cmath>
#include <numbers>
#include <optional>

#include "framework/core/perception.hpp"
#include "tests/support/nodes.hpp"

BOOST_AUTO_TEST_SUITE(running_error_test)

using namespace tactor;
using test::at_ms;

namespace {

Wrench along(double x) {
  return {{0, x, 0}, {}};
}

double wave(double t_s) {
  return 2 * std::sin(2 * std::numbers::pi * 3 * t_s);
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_wave_that_is_late_has_the_delay_and_the_error_of_its_closed_form) {
  RunningError error;
  const double late = 0.0125;
  for (int i = 0; i < 5000; ++i) {
    error.add_true(at_ms(i), along(wave(i * 1e-3)));
    error.add_displayed(at_ms(i), along(wave(i * 1e-3 - late)));
    if (i % 7 == 0) error.compare();
  }
  error.compare();
  const ErrorFigures found = error.figures();
  // sin(a) - sin(a - d) = 2 sin(d / 2) cos(a - d / 2)
  const double amplitude = 2 * 2 * std::sin(std::numbers::pi * 3 * late);
  BOOST_TEST(found.compared == 5000U);
  BOOST_TEST((found.until == at_ms(4999)));
  BOOST_TEST((found.covered == Duration{4'999'000'000}));
  BOOST_TEST(found.rms_N == amplitude / std::numbers::sqrt2, boost::test_tools::tolerance(1e-3));
  BOOST_TEST(found.rms_lately_N == amplitude / std::numbers::sqrt2, boost::test_tools::tolerance(1e-2));
  BOOST_TEST(found.max_N == amplitude, boost::test_tools::tolerance(1e-3));
  BOOST_REQUIRE(found.delay.has_value());
  BOOST_TEST(found.delay->seconds() == late, boost::test_tools::tolerance(1e-2));
}

BOOST_AUTO_TEST_CASE(a_force_that_rises_slowly_is_late_by_what_a_held_sample_is_late) {
  // Rises for two seconds with small waves on it, shown 12 ms late and held for 16 ms: 20 ms late in the mean.
  const auto rise = [](double t_s) { return 3 - 3 * std::cos(t_s) + 0.02 * std::sin(2 * std::numbers::pi * 7 * t_s); };
  RunningError error;
  for (int i = 0; i < 2500; ++i) {
    error.add_true(at_ms(i), along(rise(i * 1e-3)));
    error.add_displayed(at_ms(i), along(rise((i / 16 * 16 - 12) * 1e-3)));
  }
  error.compare();
  BOOST_REQUIRE(error.figures().delay.has_value());
  BOOST_TEST(error.figures().delay->seconds() == 0.0195, boost::test_tools::tolerance(0.1));
}

BOOST_AUTO_TEST_CASE(forces_that_have_nothing_in_common_have_no_delay) {
  RunningError error;
  for (int i = 0; i < 2500; ++i) {
    error.add_true(at_ms(i), along(wave(i * 1e-3)));
    error.add_displayed(at_ms(i), along(wave(i * 2.3e-3)));
  }
  error.compare();
  BOOST_TEST(!error.figures().delay.has_value());
}

BOOST_AUTO_TEST_CASE(a_true_force_between_two_samples_is_on_the_line_between_them) {
  RunningError error;
  for (int i = 0; i <= 10; ++i) error.add_true(at_ms(10 * i), along(i));
  for (int i = 0; i < 100; ++i) error.add_displayed(at_ms(i), along(0.1 * i + 0.25));
  error.compare();
  BOOST_TEST(error.figures().compared == 100U);
  BOOST_TEST(error.figures().max_N == 0.25, boost::test_tools::tolerance(1e-12));
  BOOST_TEST(error.figures().rms_N == 0.25, boost::test_tools::tolerance(1e-12));
}

BOOST_AUTO_TEST_CASE(what_is_not_known_yet_waits_and_what_lies_before_a_new_begin_is_not_counted) {
  RunningError error;
  BOOST_TEST(error.figures().compared == 0U);
  error.add_displayed(at_ms(5), along(1));
  error.compare();
  BOOST_TEST(error.figures().compared == 0U);
  error.add_true(at_ms(4), along(0));
  error.compare();
  BOOST_TEST(error.figures().compared == 0U);
  error.add_true(at_ms(6), along(0));
  error.compare();
  BOOST_TEST(error.figures().compared == 1U);
  BOOST_TEST(!error.figures().delay.has_value());
  error.begin_again(at_ms(100));
  for (int i = 50; i < 200; ++i) {
    error.add_true(at_ms(i), along(0));
    error.add_displayed(at_ms(i), along(i < 100 ? 1000 : 3));
  }
  error.compare();
  BOOST_TEST(error.figures().compared == 101U);
  BOOST_TEST(error.figures().max_N == 3);
}

BOOST_AUTO_TEST_CASE(what_is_not_finite_or_out_of_order_is_not_compared) {
  RunningError error;
  error.add_true(at_ms(0), along(1));
  error.add_true(at_ms(10), along(1));
  error.add_true(at_ms(5), along(99));
  error.add_true(at_ms(12), along(std::nan("")));
  error.add_displayed(at_ms(1), along(std::nan("")));
  error.add_displayed(at_ms(2), along(2));
  error.add_displayed(at_ms(1), along(50));
  error.compare();
  BOOST_TEST(error.figures().compared == 1U);
  BOOST_TEST(error.figures().max_N == 1);
}

BOOST_AUTO_TEST_CASE(what_is_felt_is_told_of_the_last_second) {
  RunningError error;
  const double frequency = 100, mass = 0.05, threshold = vibration_force_threshold(frequency, mass);
  BOOST_TEST(!error.felt(mass).has_value());
  // For two seconds the error is large and slow. Then it is a vibration of twice its threshold, which is no wrong force
  // beside 3 N.
  for (int i = 0; i < 4000; ++i) {
    const double t = i * 1e-3;
    const double vibration = 2 * threshold * std::numbers::sqrt2 * std::sin(2 * std::numbers::pi * frequency * t);
    error.add_true(at_ms(i), along(3));
    error.add_displayed(at_ms(i), along(i < 2000 ? 4 : 3 + vibration));
    error.compare();
    if (i == 1999) BOOST_TEST(error.felt(mass)->beyond_weber == 1);
  }
  const std::optional<FeltLately> found = error.felt(mass);
  BOOST_REQUIRE((found && found->vibration));
  BOOST_TEST(found->beyond_weber == 0);
  BOOST_TEST(found->vibration->mean_Hz == 100);
  BOOST_TEST(std::abs(found->vibration->mean_dB - 20 * std::log10(2)) < 0.5);
  // Nothing is known of what has not been compared yet.
  error.begin_again(at_ms(4300));
  BOOST_TEST(!error.felt(mass).has_value());
}

BOOST_AUTO_TEST_SUITE_END()
