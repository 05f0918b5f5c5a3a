// A filter with gains computed beforehand: those of the Riccati equation, and the spectra that it tells.
#include <boost/test/unit_test.hpp>

#include <cmath>
#include <complex>
#include <numbers>
#include <tuple>

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/normal_distribution.hpp>
#include <boost/random/uniform_01.hpp>

#include "framework/realtime/motion_filter.hpp"
#include "framework/realtime/steady_model.hpp"

BOOST_AUTO_TEST_SUITE(steady_model_test)

using namespace tactor;
namespace tt = boost::test_tools;

namespace {

constexpr double departure = 2e-6, noise = 1e-5 / 3.4641016151377544;  // m

Vec3 take(SteadyModel& model, double nominal, double interval, const Vec3& sample) {
  const SteadyModel::Lookup at = SteadyModel::find(interval, nominal);
  model.predict(at);
  return model.correct(at, sample);
}

}  // namespace

BOOST_AUTO_TEST_CASE(gains_and_likelihoods_are_those_of_the_recursion_when_it_has_settled) {
  boost::random::mt19937_64 engine(3);
  boost::random::normal_distribution<double> normal(0, 1);
  for (const double nominal : {2.5e-4, 1e-3, 5e-3}) {
    for (const std::size_t order : {3, 4}) {
      for (const double by : {0.0625, 0.25, 1.0, 64.0, 1024.0}) {
        MotionModel exact(by * departure, noise, order);
        SteadyModel steady({order, by * departure, 0, {}, 0}, noise, nominal);
        exact.start({});
        steady.start({});
        for (int k = 1; k < 6000; ++k) {
          // One late sample, and one early, each long after the last.
          const double interval = k == 5000 ? 2 * nominal : k == 5900 ? 0.5 * nominal : nominal;
          const Vec3 sample{1e-5 * normal(engine), 1e-5 * normal(engine), 0};
          exact.predict(interval);
          const Vec3 likely = exact.correct(sample), found = take(steady, nominal, interval, sample);
          if (k < 4000 || (k > 5000 && k != 5900)) continue;
          const double most = k <= 5000 ? 1e-6 : 1e-4;
          BOOST_REQUIRE_SMALL(norm(steady.value() - exact.value()), most * (1e-4 + norm(exact.value())));
          BOOST_REQUIRE_SMALL(norm(steady.rate() - exact.rate()), most * (1e-3 + norm(exact.rate())));
          BOOST_REQUIRE_SMALL(norm(found - likely), 10 * most);
        }
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(the_response_is_what_a_sinusoid_shows) {
  constexpr double nominal = 1e-3, stiffness = 35;
  for (const MotionLaw& law :
       {MotionLaw{3, departure, 0, {}, 0}, {4, 4 * departure, 0, {}, 0}, {3, departure, 5e-5, {9, 11}, 0.1}}) {
    for (const double hertz : {2.0, 10.0, 100.0}) {
      SteadyModel model(law, noise, nominal);
      model.start({});
      const double w = 2 * std::numbers::pi * hertz;
      std::complex<double> sum;
      constexpr int settling = 20'000, count = 10'000;
      for (int k = 1; k <= settling + count; ++k) {
        take(model, nominal, nominal, {std::cos(w * k * nominal), 0, 0});
        if (k <= settling) continue;
        sum += (stiffness * model.value().x + model.rate().x) * std::polar(2.0 / count, -w * k * nominal);
      }
      const std::complex<double> told = model.response(w, stiffness);
      BOOST_TEST(std::abs(sum - told) < 1e-6 * std::abs(told));
    }
  }
}

BOOST_AUTO_TEST_CASE(the_spectrum_of_a_tremor_integrates_to_its_mean_square) {
  constexpr double tremor = 5e-5;
  for (const auto& [low, high, damping] : {std::tuple(6.3, 7.7, 0.1), {9.0, 11.0, 0.1}, {6.0, 20.0, 0.4}}) {
    const SteadyModel calm({3, 1e-5 * departure, 0, {}, 0}, noise, 1e-3);
    const SteadyModel trembles({3, 1e-5 * departure, tremor, {low, high}, damping}, noise, 1e-3);
    double sum = 0;
    constexpr double step = 0.01;  // Hz
    for (double f = step / 2; f < 400; f += step) {
      const double w = 2 * std::numbers::pi * f;
      sum += 2 * step * (trembles.spectrum(w) - calm.spectrum(w));
    }
    BOOST_TEST(sum == tremor * tremor, tt::tolerance(1e-3));
  }
}

BOOST_AUTO_TEST_CASE(two_short_intervals_without_a_sample_move_it_as_one_long_one) {
  constexpr double nominal = 1e-3;
  const auto moved = [&](int parts, double interval) {
    SteadyModel model({3, departure, 5e-5, {12.6, 15.4}, 0.1}, noise, nominal);
    model.start({});
    for (int k = 0; k < 4000; ++k) take(model, nominal, nominal, {5e-5 * std::sin(0.088 * k), 1e-3 * k, 0});
    for (int k = 0; k < parts; ++k) model.predict(SteadyModel::find(interval / parts, nominal));
    return model.value();
  };
  for (const double interval : {0.9e-3, 1.5e-3, 2.3e-3}) {
    BOOST_TEST(norm(moved(1, interval) - moved(2, interval)) < 1e-7);
  }
}

BOOST_AUTO_TEST_CASE(what_is_slow_stays_stable_at_all_intervals_that_it_takes) {
  boost::random::mt19937_64 engine(5);
  boost::random::uniform_01<double> uniform;
  int tried = 0;
  for (const double nominal : {2.5e-4, 1e-3, 3e-3}) {
    for (const double step : {1e-7, 1e-6, 1e-5, 5e-5}) {
      for (const double hertz : {7.0, 19.0}) {
        for (const double tremor : {10.0, 160.0}) {
          for (int pattern = 0; pattern < 6; ++pattern) {
            SteadyModel model({3, departure, tremor * departure, {0.9 * hertz, 1.1 * hertz}, 0.1}, step, nominal);
            if (!model.slow()) continue;
            ++tried;
            model.start({1, 1, 1}, {10, 10, 10});
            double t = 0;
            for (int k = 0; t < 20; ++k) {
              const double by = pattern == 0   ? 0.43
                                : pattern == 1 ? 2.37
                                : pattern == 2 ? (k % 2 == 0 ? 0.43 : 2.37)
                                : pattern == 3 ? (k % 3 == 0 ? 0.43 : 2.37)
                                : pattern == 4 ? (k % 3 == 0 ? 2.37 : 0.43)
                                               : 0.43 + 1.94 * uniform(engine);
              take(model, nominal, by * nominal, {});
              t += by * nominal;
            }
            BOOST_TEST(norm(model.value()) < 1e-6);
            BOOST_TEST(norm(model.rate()) < 1e-6);
          }
        }
      }
    }
  }
  BOOST_TEST(tried > 150);
}

BOOST_AUTO_TEST_SUITE_END()
