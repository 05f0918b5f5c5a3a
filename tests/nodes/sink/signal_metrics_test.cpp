// Each measure on signals whose figures are known in closed form.
#include "nodes/sink/signal_metrics.hpp"

#include <boost/test/unit_test.hpp>
#include <cmath>
#include <numbers>
#include <vector>

using namespace tactor;

namespace {

constexpr double pi = std::numbers::pi;
using Signal = std::vector<Vec3>;

// One sample a ms.
template <class F>
Signal sampled(int n, F f) {
  Signal x;
  for (int i = 0; i < n; ++i) x.push_back(f(1e-3 * i));
  return x;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_delayed_sine_is_told_with_its_delay_and_sign) {
  for (const double delay_ms : {-12.4, -3.0, 0.0, 0.3, 5.0, 29.6, 77.7}) {
    const auto wave = [](double t) {
      return Vec3{std::sin(2 * pi * 1.0 * t), 2 * std::cos(2 * pi * 1.7 * t) + 5, 0.5 * std::sin(2 * pi * 3.1 * t)};
    };
    const Signal r = sampled(10000, wave);
    const Signal x = sampled(10000, [&](double t) { return wave(t - 1e-3 * delay_ms); });
    const auto delay = delay_steps(x, r, 100);
    BOOST_REQUIRE(delay.has_value());
    BOOST_TEST(std::abs(*delay - delay_ms) < 0.1, "found " << *delay << " for " << delay_ms);
  }
}

BOOST_AUTO_TEST_CASE(a_sine_sampled_and_held_is_half_a_hold_late) {
  // Held for 10 samples: delays of 0 to 9 samples, 4.5 in the mean.
  const auto wave = [](double t) { return Vec3{std::sin(2 * pi * t), 0, 0}; };
  const Signal r = sampled(10000, wave);
  const Signal x = sampled(10000, [&](double t) { return wave(0.010 * std::floor(t / 0.010 + 1e-9)); });
  BOOST_TEST(std::abs(delay_steps(x, r, 100).value() - 4.5) < 0.1);
  // The error at a delay d is 2 sin(pi d) cos(...), whose RMS is sqrt(2) sin(pi d).
  double sum = 0;
  for (int d = 0; d < 10; ++d) sum += 2 * std::pow(std::sin(pi * 1e-3 * d), 2);
  BOOST_TEST(std::abs(rms_error(x, r) - std::sqrt(sum / 10)) < 1e-9);
}

BOOST_AUTO_TEST_CASE(a_constant_signal_has_no_delay) {
  const Signal r = sampled(1000, [](double t) { return Vec3{t, 0, 0}; });
  const Signal x = sampled(1000, [](double) { return Vec3{0.1, 0.2, 0.3}; });
  BOOST_TEST(!delay_steps(x, r, 100).has_value());
  BOOST_TEST(!delay_steps(r, x, 100).has_value());
  BOOST_TEST(!delay_steps(Signal(200), Signal(200), 100).has_value());
}

BOOST_AUTO_TEST_CASE(differences_of_a_sine_are_its_known_ones) {
  constexpr double f = 5;
  const Signal x = sampled(10000, [](double t) {
    return Vec3{3 * std::sin(2 * pi * f * t), 3 * std::cos(2 * pi * f * t), 0};
  });
  // A step of the circle of radius 3 is the chord 6 sin(pi f h), and of the circle of chords again.
  const double chord = 2 * std::sin(pi * f * 1e-3);
  const Smoothness s = smoothness(x, 1.0);
  BOOST_TEST(std::abs(s.rms_d1 - 3 * chord) < 1e-12);
  BOOST_TEST(std::abs(s.rms_d2 - 3 * chord * chord) < 1e-12);
  BOOST_TEST(std::abs(s.max_step - 3 * chord) < 1e-12);
  const Smoothness half = smoothness(x, 0.5);
  BOOST_TEST(std::abs(half.rms_d1 - 2 * s.rms_d1) < 1e-12);
  BOOST_TEST(std::abs(half.rms_d2 - 4 * s.rms_d2) < 1e-12);
}

BOOST_AUTO_TEST_CASE(errors_are_over_the_norm_of_the_axes) {
  const Signal r(4);
  const Signal x{{3, 4, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
  BOOST_TEST(rms_error(x, r) == 2.5);
  BOOST_TEST(max_error(x, r) == 5.0);
  BOOST_TEST(rms(x) == 2.5);
}

BOOST_AUTO_TEST_CASE(share_beyond_takes_the_larger_of_floor_and_fraction) {
  const Signal r{{0, 0, 0}, {0, 0, 0}, {10, 0, 0}, {10, 0, 0}, {0.5, 0, 0}};
  const Signal x{{0.03, 0, 0}, {0, 0.05, 0}, {10.6, 0, 0}, {10, 0.8, 0}, {0.5, 0, 0.039}};
  BOOST_TEST(share_beyond(x, r, 0.04, 0.07) == 2.0 / 5);
}

BOOST_AUTO_TEST_CASE(overshoot_is_the_push_the_wrong_way_after_a_loss) {
  // Contact of 2 N along z until sample 100, then nothing; what is shown dips to -0.3 N at sample 110.
  const auto dip = [](double floor) {
    return sampled(400, [floor](double t) {
      return Vec3{0, 0, t < 0.0995 ? 2.0 : std::abs(t - 0.110) < 1e-6 ? floor : 0.0};
    });
  };
  const Signal r = sampled(400, [](double t) { return Vec3{0, 0, t < 0.0995 ? 2.0 : 0.0}; });
  BOOST_TEST(std::abs(after_loss(dip(-0.3), r, 0.2, 200).overshoot - 0.3) < 1e-12);
  // A force that is only late still points the right way.
  BOOST_TEST(after_loss(dip(0.3), r, 0.2, 200).overshoot == 0.0);
  BOOST_TEST(after_loss(dip(-0.3), r, 0.2, 5).overshoot == 0.0);
}

BOOST_AUTO_TEST_CASE(a_ghost_is_what_still_pushes_when_what_is_late_has_passed) {
  const Signal r = sampled(400, [](double t) { return Vec3{0, 0, t < 0.0995 ? 2.0 : 0.0}; });
  // Late by 40 ms: no ghost in a window of 200 ms.
  const Signal late = sampled(400, [](double t) { return Vec3{0, 0, t < 0.1395 ? 2.0 : 0.0}; });
  BOOST_TEST(after_loss(late, r, 0.2, 200).ghost == 0.0);
  // A fifth of a newton that stays.
  const Signal stays = sampled(400, [](double t) { return Vec3{0, 0, t < 0.0995 ? 2.0 : 0.2}; });
  BOOST_TEST(std::abs(after_loss(stays, r, 0.2, 200).ghost - 0.2) < 1e-12);
  BOOST_TEST(after_loss(stays, r, 0.2, 200).overshoot == 0.0);
}
