// Which of several forces has been nearest to physics, told from the run itself.
#include <boost/test/unit_test.hpp>

#include <cmath>
#include <limits>
#include <optional>

#include "nodes/interpolation/error_estimate.hpp"

BOOST_AUTO_TEST_SUITE(error_estimate_test)

using namespace tactor;
namespace tt = boost::test_tools;

namespace {

using Estimate = ErrorEstimate<3>;

Estimate estimate(double worse = 1.2) {
  return Estimate({.memory = Duration::from_seconds(1), .worse = worse, .noise = 0.01, .results = 4});
}

/// `count` results every 20 ms from `first` on, the candidates off by so much along x.
void take(Estimate& e, int first, int count, double a, double b, double c, std::optional<double> law = 10) {
  const Vec3 physics{1, 2, 3};
  for (int k = first; k < first + count; ++k) {
    e.take(Time::from_seconds(0.02 * k), physics,
           {physics + Vec3{a, 0, 0}, physics + Vec3{b, 0, 0}, physics + Vec3{c, 0, 0}}, law);
  }
}

}  // namespace

BOOST_AUTO_TEST_CASE(errors_are_root_mean_squares_that_fade_exponentially) {
  Estimate e = estimate();
  take(e, 0, 50, 0.3, 0.2, 0.5);
  BOOST_TEST(e.error(0) == 0.3, tt::tolerance(1e-12));
  BOOST_TEST(e.error(2) == 0.5, tt::tolerance(1e-12));
  take(e, 50, 50, 0, 0.2, 0.5);  // for 1 s
  BOOST_TEST(e.error(0) == 0.3 * std::exp(-0.5), tt::tolerance(1e-9));
}

BOOST_AUTO_TEST_CASE(the_first_stays_until_it_is_clearly_worse_and_comes_back_when_it_is_not) {
  Estimate e = estimate();
  take(e, 0, 200, 0.23, 0.3, 0.2);
  BOOST_TEST(e.best() == 0U);
  take(e, 200, 400, 0.26, 0.3, 0.2);
  BOOST_TEST(e.best() == 2U);
  take(e, 600, 400, 0.22, 0.3, 0.2);  // worse still, but not by the ratio
  BOOST_TEST(e.best() == 2U);
  take(e, 1000, 400, 0.19, 0.3, 0.2);
  BOOST_TEST(e.best() == 0U);
}

BOOST_AUTO_TEST_CASE(where_the_law_tells_less_than_half_of_the_error_the_first_stays) {
  Estimate coarse = estimate(), foreign = estimate();
  take(coarse, 0, 100, 0.5, 0.1, 0.1, 0.24);
  take(foreign, 0, 100, 0.5, 0.1, 0.1, 0.26);
  BOOST_TEST(coarse.best() == 0U);
  BOOST_TEST(foreign.best() == 1U);
  // That nobody knows the law's error is not that it has none.
  Estimate same = estimate(), unknown = estimate();
  take(same, 0, 100, 0.5, 0.1, 0.1, 0);
  take(unknown, 0, 100, 0.5, 0.1, 0.1, std::nullopt);
  BOOST_TEST(same.best() == 0U);
  BOOST_TEST(unknown.best() == 1U);
  BOOST_TEST(unknown.error(0) == 0.5, tt::tolerance(1e-12));
  take(unknown, 100, 400, 0.05, 0.1, 0.1, std::nullopt);
  BOOST_TEST(unknown.best() == 0U);
}

BOOST_AUTO_TEST_CASE(differences_below_the_noise_and_the_first_few_results_decide_nothing) {
  Estimate small = estimate();
  take(small, 0, 100, 0.009, 0, 0);
  BOOST_TEST(small.best() == 0U);
  Estimate early = estimate();
  take(early, 0, 3, 2, 0.1, 0.1);
  BOOST_TEST(early.best() == 0U);
  take(early, 3, 1, 2, 0.1, 0.1);
  BOOST_TEST(early.best() == 1U);
}

BOOST_AUTO_TEST_CASE(results_that_are_not_finite_or_come_twice_change_nothing) {
  Estimate e = estimate();
  take(e, 0, 10, 0.1, 0.2, 0.3);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  e.take(Time::from_seconds(5), {nan, 0, 0}, {}, 1);
  e.take(Time::from_seconds(5), {}, {Vec3{}, Vec3{0, nan, 0}, Vec3{}}, 1);
  e.take(Time::from_seconds(5), {}, {}, nan);
  take(e, 3, 5, 9, 9, 9);
  BOOST_TEST(e.error(0) == 0.1, tt::tolerance(1e-12));
  BOOST_TEST(e.error(1) == 0.2, tt::tolerance(1e-12));
}

BOOST_AUTO_TEST_SUITE_END()
