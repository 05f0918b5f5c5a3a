// Each measure on signals whose metrics are known in closed form.
#include "framework/core/signal_metrics.hpp"

#include <boost/test/unit_test.hpp>
#include <cmath>
#include <numbers>
#include <vector>

BOOST_AUTO_TEST_SUITE(signal_metrics_test)

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

BOOST_AUTO_TEST_CASE(a_tremor_does_not_add_its_period_to_a_delay) {
  // A tremor of 10 Hz on a slow wave: the correlation is nearly as high one period of 100 ms away.
  const auto wave = [](double t) { return Vec3{0.1 * std::sin(2 * pi * 0.2 * t), std::sin(2 * pi * 10 * t), 0}; };
  for (const double delay_ms : {-20.0, 0.0, 7.0, 30.5}) {
    const Signal r = sampled(10000, wave);
    // The slow wave is a period of the tremor later still, so that the highest peak is the one a period too late.
    const Signal x = sampled(10000, [&](double t) {
      return Vec3{0.1 * std::sin(2 * pi * 0.2 * (t - 0.1 - 1e-3 * delay_ms)),
                  std::sin(2 * pi * 10 * (t - 1e-3 * delay_ms)), 0};
    });
    const auto delay = delay_steps(x, r, 150);
    BOOST_REQUIRE(delay.has_value());
    BOOST_TEST(std::abs(*delay - delay_ms) < 0.2, "found " << *delay << " for " << delay_ms);
  }
}

BOOST_AUTO_TEST_CASE(the_end_of_the_search_is_no_peak) {
  // Later than what is looked for: the correlation rises up to the end of the range.
  const auto wave = [](double t) { return Vec3{std::sin(2 * pi * 0.5 * t), 0, 0}; };
  const Signal r = sampled(10000, wave);
  const Signal x = sampled(10000, [&](double t) { return wave(t - 0.15); });
  BOOST_TEST(!delay_steps(x, r, 100).has_value());
  BOOST_TEST(!delay_steps(r, x, 100).has_value());
  BOOST_TEST(std::abs(delay_steps(x, r, 200).value() - 150) < 0.5);
}

BOOST_AUTO_TEST_CASE(a_slow_force_that_is_late_is_told_with_its_delay) {
  // A force that rises for seconds: one far away in time is much the same, and only its small bends tell the delay.
  const auto press = [](double t) {
    return Vec3{0, 0.02 * std::sin(2 * pi * 3 * t),
                2 / (1 + std::exp(-1.5 * (t - 3))) + 0.03 * std::sin(2 * pi * 1.3 * t)};
  };
  const Signal r = sampled(6000, press);
  for (const double delay_ms : {-8.0, 0.0, 4.0, 18.2, 40.0}) {
    const Signal x = sampled(6000, [&](double t) { return press(t - 1e-3 * delay_ms); });
    const auto delay = delay_of_changes(x, r, 100, 20);
    BOOST_REQUIRE(delay.has_value());
    BOOST_TEST(std::abs(*delay - delay_ms) < 0.1, "found " << *delay << " for " << delay_ms);
  }
}

BOOST_AUTO_TEST_CASE(a_delay_explains_what_it_leaves_less_than_half_of) {
  const auto wave = [](double t) { return Vec3{std::sin(2 * pi * 2 * t), 0, 0}; };
  const Signal r = sampled(4000, wave);
  // Late by 10 ms, and off by a constant besides. The wave varies by 1 / sqrt(2) in RMS; half of that is 0.354.
  const auto off_by = [&](double offset) {
    return sampled(4000, [&](double t) { return wave(t - 0.01) + Vec3{0, offset, 0}; });
  };
  BOOST_TEST(is_explained_by(10, off_by(0), r));
  BOOST_TEST(is_explained_by(10, off_by(0.34), r));
  BOOST_TEST(!is_explained_by(10, off_by(0.37), r));
  BOOST_TEST(!is_explained_by(135, off_by(0), r));
}

BOOST_AUTO_TEST_CASE(without_a_loss_there_is_nothing_after_it) {
  const Signal r = sampled(400, [](double t) { return Vec3{0, 0, t < 0.1 ? 0.0 : 2.0}; });
  BOOST_TEST(!after_loss(Signal(400), r, 0.2, 200).has_value());
  BOOST_TEST(!after_loss(Signal(400), Signal(400), 0.2, 200).has_value());
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

BOOST_AUTO_TEST_CASE(what_is_above_a_frequency_is_kept_by_the_filters_known_gain) {
  const auto gain = [](double f) { return 1 / (1 + std::pow(std::tan(pi * 30 * 1e-3) / std::tan(pi * f * 1e-3), 8)); };
  BOOST_TEST(std::abs(gain(30) - 0.5) < 1e-12);
  for (const double f : {2.0, 15.0, 25.0, 30.0, 36.0, 80.0, 310.0}) {
    // Whole periods in 10 s. A circle has the same norm at all times, so its RMS is its radius.
    const Signal x = sampled(10000, [f](double t) {
      return Vec3{3 * std::cos(2 * pi * f * t), 3 * std::sin(2 * pi * f * t), 0};
    });
    const double found = rms_above(x, 30, 1000);
    // The reflection at the ends bends the cosine; that is felt for a few periods out of many.
    BOOST_TEST(std::abs(found - 3 * gain(f)) < 0.01, f << " Hz: found " << found << ", expected " << 3 * gain(f));
  }
}

BOOST_AUTO_TEST_CASE(constants_and_slow_ramps_have_nothing_above_a_frequency) {
  BOOST_TEST(rms_above(sampled(500, [](double) { return Vec3{5, -2, 1}; }), 30, 1000) < 1e-12);
  // Its own reflection through the ends continues a line.
  BOOST_TEST(rms_above(sampled(500, [](double t) { return Vec3{5 + 3 * t, 0, -t}; }), 30, 1000) < 1e-3);
  BOOST_TEST(rms_above(Signal(1), 30, 1000) == 0.0);
}

BOOST_AUTO_TEST_CASE(a_signal_turned_round_in_time_has_as_much_above_a_frequency) {
  const Signal x = sampled(1000, [](double t) { return Vec3{t > 0.4 ? 1.0 : 0.0, std::exp(-20 * t), 0}; });
  const Signal turned(x.rbegin(), x.rend());
  BOOST_TEST(std::abs(rms_above(x, 30, 1000) - rms_above(turned, 30, 1000)) < 1e-3 * rms_above(x, 30, 1000));
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
  BOOST_TEST(std::abs(after_loss(dip(-0.3), r, 0.2, 200)->overshoot - 0.3) < 1e-12);
  // A force that is only late still points the right way.
  BOOST_TEST(after_loss(dip(0.3), r, 0.2, 200)->overshoot == 0.0);
  BOOST_TEST(after_loss(dip(-0.3), r, 0.2, 5)->overshoot == 0.0);
}

BOOST_AUTO_TEST_CASE(only_a_force_towards_the_surface_is_an_overshoot) {
  // The reference fades from 0.2 N to 0 after the loss; what is shown is gone at once, which pulls nobody in.
  const auto fading = [](double t) { return Vec3{0, 0, t < 0.0995 ? 2.0 : std::max(0.0, 0.2 - (t - 0.1))}; };
  const Signal r = sampled(400, fading);
  BOOST_TEST(after_loss(sampled(400,
                                [](double t) {
                                  return Vec3{0, 0, t < 0.0995 ? 2.0 : 0.0};
                                }),
                        r, 0.2, 200)
                 ->overshoot == 0.0);
  // Of 0.15 N towards the surface, 0.1 N are the drag of the tool that the reference has too.
  const auto drag = [](double force) {
    return sampled(400, [force](double t) { return Vec3{0, 0, t < 0.0995 ? 2.0 : -force}; });
  };
  BOOST_TEST(std::abs(after_loss(drag(0.15), drag(0.1), 0.2, 200)->overshoot - 0.05) < 1e-12);
  BOOST_TEST(after_loss(drag(0.05), drag(0.1), 0.2, 200)->overshoot == 0.0);
}

BOOST_AUTO_TEST_CASE(a_ghost_is_what_still_pushes_when_what_is_late_has_passed) {
  const Signal r = sampled(400, [](double t) { return Vec3{0, 0, t < 0.0995 ? 2.0 : 0.0}; });
  // Late by 40 ms: no ghost in a window of 200 ms.
  const Signal late = sampled(400, [](double t) { return Vec3{0, 0, t < 0.1395 ? 2.0 : 0.0}; });
  BOOST_TEST(after_loss(late, r, 0.2, 200)->ghost == 0.0);
  // A fifth of a newton that stays.
  const Signal stays = sampled(400, [](double t) { return Vec3{0, 0, t < 0.0995 ? 2.0 : 0.2}; });
  BOOST_TEST(std::abs(after_loss(stays, r, 0.2, 200)->ghost - 0.2) < 1e-12);
  BOOST_TEST(after_loss(stays, r, 0.2, 200)->overshoot == 0.0);
}

BOOST_AUTO_TEST_SUITE_END()
