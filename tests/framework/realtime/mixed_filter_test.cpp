// The velocity that filters of several motions give together: smooth to a hand, exact where motion is steady, never
// wild.
#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/normal_distribution.hpp>
#include <boost/random/uniform_real_distribution.hpp>

#include "framework/core/perception.hpp"
#include "framework/core/third_octaves.hpp"
#include "framework/realtime/mixed_filter.hpp"
#include "framework/realtime/motion_filter.hpp"

BOOST_AUTO_TEST_SUITE(mixed_filter_test)

using namespace tactor;
namespace tt = boost::test_tools;

namespace {

constexpr double departure = 2e-6, stiffness = 35;  // m, 1/s

struct Judged {
  double rms;    // of k p + b v, by b
  double level;  // the largest third of an octave by the threshold of feeling
};

/// A calm hand: it moves by a slow sum of sinusoids of some millimetres, and trembles by some micrometres.
struct Hand {
  double amplitude, hertz, tremor, tremor_hertz;
  [[nodiscard]] Vec3 at(double t) const {
    const double w = 2 * std::numbers::pi * hertz, u = 2 * std::numbers::pi * tremor_hertz;
    return {amplitude * std::sin(w * t) + tremor * std::sin(u * t), amplitude * std::cos(0.7 * w * t),
            0.3 * amplitude * std::sin(0.9 * w * t) + tremor * std::cos(1.1 * u * t)};
  }
  [[nodiscard]] Vec3 rate(double t) const {
    const double w = 2 * std::numbers::pi * hertz, u = 2 * std::numbers::pi * tremor_hertz;
    return {amplitude * w * std::cos(w * t) + tremor * u * std::cos(u * t),
            -amplitude * 0.7 * w * std::sin(0.7 * w * t),
            0.27 * amplitude * w * std::cos(0.9 * w * t) - 1.1 * tremor * u * std::sin(1.1 * u * t)};
  }
};

template <class Filter>
Judged judge(Filter filter, const Hand& hand, double rate, double step) {
  std::vector<Vec3> errors;
  const auto shown = [&](double t) {
    const Vec3 p = hand.at(t);
    return Vec3{step * std::round(p.x / step), step * std::round(p.y / step), step * std::round(p.z / step)};
  };
  filter.start(shown(0));
  double sum = 0;
  for (int k = 1; k < 6 * rate; ++k) {
    const double t = k / rate;
    filter.take(1 / rate, shown(t));
    if (t < 1) continue;
    errors.push_back(stiffness * (shown(t) - hand.at(t)) + filter.rate() - hand.rate(t));
    sum += dot(errors.back(), errors.back());
  }
  Judged found{std::sqrt(sum / static_cast<double>(errors.size())), 0};
  for (const ThirdOctave& band : third_octaves(rate)) {
    double squares = 0;
    for (const double square : band_squares(errors, band, rate)) squares += square;
    const double threshold = vibration_force_threshold(band.centre_Hz, 0.1);
    found.level = std::max(found.level, std::sqrt(squares / static_cast<double>(errors.size())) / threshold);
  }
  return found;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_calm_hand_is_shown_with_less_vibration_and_hardly_more_error) {
  for (const double rate : {1000.0, 2000.0, 4000.0}) {
    for (const double step : {1e-5, 5e-5}) {
      const double noise = step / std::sqrt(12.0);
      for (const Hand& hand : {Hand{5e-3, 0.3, 0, 1}, {10e-3, 0.2, 3e-5, 9}, {2e-3, 0.7, 1e-5, 7}}) {
        const Judged before = judge(MotionFilter(departure, noise), hand, rate, step);
        const Judged now = judge(MixedFilter(departure, noise, 1 / rate), hand, rate, step);
        // Far under the threshold it is of no use to be lower still.
        BOOST_TEST(now.level < std::max(0.8 * before.level, 0.25));
        BOOST_TEST(now.rms < 1.1 * before.rms);
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(a_fast_motion_is_followed_as_well_as_by_the_models_alone) {
  for (const double rate : {1000.0, 4000.0}) {
    const double step = 1e-5, noise = step / std::sqrt(12.0);
    for (const double hertz : {20.0, 40.0, 80.0}) {
      const Hand hand{2e-4, hertz, 0, 1};
      const Judged before = judge(MotionFilter(departure, noise), hand, rate, step);
      BOOST_TEST(judge(MixedFilter(departure, noise, 1 / rate), hand, rate, step).rms < 1.05 * before.rms);
    }
  }
}

BOOST_AUTO_TEST_CASE(a_broad_motion_is_shown_hardly_too_stiff_at_its_slow_frequencies) {
  constexpr double rate = 1000, first = 1, step = 1e-5;     // Hz, Hz, m
  constexpr int lines = 21, settling = 1000, count = 8000;  // whole periods of each distance between lines
  struct Motion {
    double value = 0, rate = 0;
  };
  boost::random::mt19937_64 engine(5);
  boost::random::uniform_real_distribution<double> any(0, 2 * std::numbers::pi);
  for (const double apart : {0.5, 1.0, 1.75, 2.5}) {  // Hz
    for (const double speed : {0.5e-3, 1e-3, 2e-3}) {
      std::vector<double> phases(lines);
      for (double& phase : phases) phase = any(engine);
      const auto w = [&](int k) { return 2 * std::numbers::pi * (first + apart * k); };
      // All lines have the same velocity.
      const auto at = [&](double t) {
        Motion motion;
        for (int k = 0; k < lines; ++k) {
          motion.value += speed / w(k) * std::cos(w(k) * t + phases[k]);
          motion.rate -= speed * std::sin(w(k) * t + phases[k]);
        }
        return motion;
      };
      MixedFilter filter(departure, step / std::sqrt(12.0), 1 / rate);
      filter.start({at(0).value, 0, 0});
      std::vector<std::complex<double>> found(lines), wanted(lines);
      for (int n = 1; n <= settling + count; ++n) {
        const double t = n / rate, shown = step * std::round(at(t).value / step);
        filter.take(1 / rate, {shown, 0, 0});
        if (n <= settling) continue;
        for (int k = 0; k < lines; ++k) {
          const std::complex<double> turn = std::polar(1.0, -w(k) * t);
          found[k] += turn * (stiffness * shown + filter.rate().x);
          wanted[k] += turn * (stiffness * at(t).value + at(t).rate);
        }
      }
      for (int k = 0; k < lines && first + apart * k < 5; ++k) {
        BOOST_TEST(std::abs(20 * std::log10(std::abs(found[k] / wanted[k]))) < 0.7);
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(estimates_stay_finite_and_near_whatever_the_intervals_and_parameters) {
  boost::random::mt19937_64 engine(11);
  boost::random::normal_distribution<double> normal(0, 1);
  for (const double nominal : {1e-4, 1e-3, 4e-3}) {
    for (const double step : {1e-9, 1e-7, 1e-5, 1e-3}) {
      for (const double d : {1e-9, departure, 1e-3, 1.0}) {
        MixedFilter filter(d, step, nominal);
        MotionFilter before(d, step);
        filter.start({});
        before.start({});
        double t = 0, most = 0, most_before = 0, off = 0, off_before = 0;
        for (int k = 0; k < 5000; ++k) {
          const double spread = k % 1000 == 0 ? 5 : k / 1000 % 2 == 0 ? 0.1 : 0.5;
          const double T = std::min(1.0, nominal * std::exp(spread * normal(engine)));
          t += T;
          const double z = 0.01 * std::sin(t / (50 * nominal)) + step * normal(engine);
          filter.take(T, {z, 0, 0});
          BOOST_REQUIRE(std::isfinite(filter.rate().x));
          BOOST_REQUIRE(filter.rate().y == 0.0);
          before.take(T, {z, 0, 0});
          BOOST_REQUIRE(std::isfinite(before.rate().x));
          off = std::max(off, std::abs(filter.value().x - z));
          off_before = std::max(off_before, std::abs(before.value().x - z));
          most = std::max(most, std::abs(filter.rate().x));
          most_before = std::max(most_before, std::abs(before.rate().x));
        }
        // Samples that follow each other at once make a large velocity with any filter.
        BOOST_TEST(most < 2 * most_before);
        BOOST_TEST(off < 2 * off_before + 20 * step);
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(a_wild_sample_makes_little_velocity_and_is_forgotten) {
  const double noise = 1e-5 / std::sqrt(12.0), period = 1e-3;
  for (const double jump : {1e-4, 1e-3, 1e-2}) {
    MixedFilter filter(departure, noise, period);
    MotionFilter before(departure, noise);
    filter.start({});
    before.start({});
    double most = 0, most_before = 0;
    for (int k = 1; k < 2000; ++k) {
      const Vec3 sample{k == 1000 ? jump : 0.0, 0, 0};
      filter.take(period, sample);
      before.take(period, sample);
      most = std::max(most, std::abs(filter.rate().x));
      most_before = std::max(most_before, std::abs(before.rate().x));
    }
    BOOST_TEST(most < 1.2 * most_before);
    BOOST_TEST(std::abs(filter.rate().x) < 1e-6 * most);
  }
}

BOOST_AUTO_TEST_CASE(it_is_the_mean_of_the_chains_while_samples_come_unevenly_and_stable_at_any_other_rate) {
  const double noise = 1e-5 / std::sqrt(12.0), period = 1e-3;
  boost::random::mt19937_64 engine(2);
  boost::random::normal_distribution<double> normal(0, 1);
  // Samples come at a fifth of the rate, or at ten times the rate; neither counts as even.
  for (const double by : {5.0, 0.1}) {
    MixedFilter filter(departure, noise, period);
    MotionFilter chains(departure, noise);
    filter.start({});
    chains.start({});
    double t = 0;
    for (int k = 0; k < 5000; ++k) {
      const double T = by * period;
      t += T;
      const Vec3 sample{1e-3 * std::sin(20 * t) + noise * normal(engine), 0, 0};
      filter.take(T, sample);
      chains.take(T, sample);
      BOOST_REQUIRE_SMALL(norm(filter.rate() - chains.rate()), 1e-5);
    }
  }
}

BOOST_AUTO_TEST_CASE(a_tremor_counts_again_half_a_second_after_a_gap_at_any_rate) {
  const double noise = 1e-5 / std::sqrt(12.0);
  for (const double rate : {1000.0, 4000.0, 10000.0, 20000.0}) {
    const double period = 1 / rate;
    MixedFilter filter(departure, noise, period);
    MotionFilter chains(departure, noise);
    filter.start({});
    chains.start({});
    double before = 0, soon = 0, later = 0, t = 0;
    const int gap = static_cast<int>(2 * rate);
    for (int k = 1; k < 2 * gap; ++k) {
      const double T = k == gap ? 5 * period : period;
      t += T;
      const Vec3 sample{1e-5 * std::round(100 * std::sin(50 * t)), 0, 0};
      filter.take(T, sample);
      chains.take(T, sample);
      const double difference = norm(filter.rate() - chains.rate()), since = (k - gap) * period;
      // At first nothing is mixed; then the chains are, and the tremors are far too unlikely to count.
      if (since >= 0 && since < 0.099) BOOST_REQUIRE_SMALL(difference, 1e-5);
      BOOST_REQUIRE(difference < 0.05);
      if (since < 0 && since > -1) before = std::max(before, difference);
      if (since > 0.1 && since < 0.2) soon = std::max(soon, difference);
      if (since > 0.7 && since < 1.7) later = std::max(later, difference);
    }
    BOOST_TEST(soon < 0.5 * before);
    BOOST_TEST(later > 0.5 * before);
  }
}

BOOST_AUTO_TEST_SUITE_END()
