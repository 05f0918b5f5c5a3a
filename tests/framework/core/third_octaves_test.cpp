// Levels of thirds of octaves: by the closed form of a Butterworth band-pass, on waves, noise and what does not pass.
#include "framework/core/third_octaves.hpp"

#include <boost/test/unit_test.hpp>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

BOOST_AUTO_TEST_SUITE(third_octaves_test)

using namespace tactor;

namespace {

constexpr double pi = std::numbers::pi;
using Signal = std::vector<Vec3>;

double mean(const std::vector<double>& x, std::size_t from = 0) {
  return std::accumulate(x.begin() + static_cast<std::ptrdiff_t>(from), x.end(), 0.0) /
         static_cast<double>(x.size() - from);
}

/// A circle of radius 3, whose norm is the same at all times.
Signal circle(double frequency, double rate, double seconds) {
  Signal x;
  for (int i = 0; i < static_cast<int>(rate * seconds); ++i) {
    const double angle = 2 * pi * frequency * i / rate;
    x.push_back({3 * std::cos(angle), 3 * std::sin(angle), 0});
  }
  return x;
}

/// |H|^2 of the band-pass of third order, after the bilinear transform.
double power_gain(const ThirdOctave& band, double frequency, double rate) {
  const auto warped = [rate](double f) { return std::tan(pi * f / rate); };
  const double low = warped(band.low_Hz), high = warped(band.high_Hz), w = warped(frequency);
  return 1 / (1 + std::pow((w * w - low * high) / (w * (high - low)), 6));
}

}  // namespace

BOOST_AUTO_TEST_CASE(bands_follow_each_other_and_end_before_half_the_rate) {
  const auto bands = third_octaves(10'000);
  BOOST_REQUIRE(bands.size() == 18u);
  BOOST_TEST(bands.front().nominal_Hz == 10);
  BOOST_TEST(bands.back().nominal_Hz == 500);
  for (std::size_t i = 1; i < bands.size(); ++i) {
    BOOST_TEST(std::abs(bands[i].low_Hz - bands[i - 1].high_Hz) < 1e-9);
    BOOST_TEST(std::abs(bands[i].nominal_Hz / bands[i].centre_Hz - 1) < 0.01);
  }
  BOOST_TEST(third_octaves(1000).back().nominal_Hz == 400);
  BOOST_TEST(third_octaves(25).size() == 1u);
  BOOST_TEST(third_octaves(24).empty());
}

BOOST_AUTO_TEST_CASE(a_wave_keeps_what_the_closed_form_says_in_every_band_at_every_rate) {
  for (const double rate : {1000.0, 4000.0}) {
    for (const ThirdOctave& band : third_octaves(rate)) {
      for (const double frequency :
           {band.centre_Hz, band.low_Hz, band.high_Hz, 0.6 * band.centre_Hz, 1.1 * band.centre_Hz}) {
        if (frequency >= rate / 2) continue;
        const Signal x = circle(frequency, rate, 4);
        // The second half: the filter has settled.
        const double found = mean(band_squares(x, band, rate), x.size() / 2);
        BOOST_TEST(std::abs(found - 9 * power_gain(band, frequency, rate)) < 0.02,
                   band.nominal_Hz << " Hz at " << frequency << " Hz, rate " << rate << ": " << found);
      }
      BOOST_TEST(std::abs(power_gain(band, band.low_Hz, rate) - 0.5) < 1e-9);
    }
  }
}

BOOST_AUTO_TEST_CASE(white_noise_has_in_each_band_its_variance_times_the_bands_share) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal(0, 0.5);
  Signal x(200'000);
  for (Vec3& v : x) v = {normal(random), normal(random), normal(random)};
  constexpr double rate = 1000;
  for (const ThirdOctave& band : third_octaves(rate)) {
    double share = 0;  // of the power up to half the rate
    constexpr int steps = 20'000;
    for (int i = 0; i < steps; ++i) share += power_gain(band, (i + 0.5) * rate / 2 / steps, rate) / steps;
    const double found = mean(band_squares(x, band, rate));
    // The level of a band of B Hz is known to 1 / sqrt(3 B 200 s) of itself; four times that.
    const double doubt = 4 / std::sqrt(3 * (band.high_Hz - band.low_Hz) * 200);
    BOOST_TEST(std::abs(found / (3 * 0.25 * share) - 1) < doubt, band.nominal_Hz << " Hz");
    // A Butterworth of third order passes pi/6 / sin(pi/6) of its width; the bilinear transform narrows high bands.
    if (band.nominal_Hz <= 50) {
      BOOST_TEST(std::abs(share / (pi / 3 * (band.high_Hz - band.low_Hz) / (rate / 2)) - 1) < 0.02);
    }
  }
}

BOOST_AUTO_TEST_CASE(constants_and_slow_changes_have_no_vibration) {
  const auto bands = third_octaves(1000);
  const Signal constant(2000, Vec3{5, -2, 1});
  for (const ThirdOctave& band : bands) BOOST_TEST(mean(band_squares(constant, band, 1000)) < 1e-20);
  // Half a hertz, 3 N: less than 2e-4 of it comes through the lowest band, where the filter begins.
  BOOST_TEST(mean(band_squares(circle(0.5, 1000, 4), bands.front(), 1000)) < 3e-7);
  BOOST_TEST(band_squares(Signal(), bands.front(), 1000).empty());
  BOOST_TEST(band_squares(Signal(1), bands.front(), 1000).size() == 1u);
}

BOOST_AUTO_TEST_SUITE_END()
