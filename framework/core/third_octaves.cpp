#include "framework/core/third_octaves.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

constexpr std::array nominal_centres{10.0, 12.5,  16.0,  20.0,  25.0,  31.5,  40.0,  50.0,  63.0,
                                     80.0, 100.0, 125.0, 160.0, 200.0, 250.0, 315.0, 400.0, 500.0};

constexpr double highest_share_of_rate = 0.45;

/// A pair of poles of a band-pass by the bilinear transform, with a zero at 0 and one at half the rate, in transposed
/// direct form II, from rest.
class BandPassPair {
 public:
  explicit BandPassPair(std::complex<double> z) : a1_(-2 * z.real()), a2_(std::norm(z)) {}

  /// The gain at the angle w per sample, without scale().
  [[nodiscard]] double gain(double w) const {
    const std::complex<double> z1 = std::polar(1.0, -w);
    return std::abs((1.0 - z1 * z1) / (1.0 + a1_ * z1 + a2_ * z1 * z1));
  }
  void scale(double b0) { b0_ = b0; }

  Vec3 step(const Vec3& in) {
    const Vec3 out = b0_ * in + s1_;
    s1_ = s2_ - a1_ * out;
    s2_ = -b0_ * in - a2_ * out;
    return out;
  }

 private:
  double b0_ = 1, a1_, a2_;
  Vec3 s1_, s2_;
};

/// Butterworth of third order between two edges, as three pairs of poles.
std::array<BandPassPair, 3> band_pass(double low_Hz, double high_Hz, double rate_Hz) {
  // In units of half the rate of samples: the bilinear transform is z = (1 + s) / (1 - s).
  const double low = std::tan(std::numbers::pi * low_Hz / rate_Hz);
  const double high = std::tan(std::numbers::pi * high_Hz / rate_Hz);
  const double centre_squared = low * high;
  const auto digital = [&](std::complex<double> low_pass_pole, double sign) {
    const std::complex<double> half = 0.5 * (high - low) * low_pass_pole;
    const std::complex<double> s = half + sign * std::sqrt(half * half - centre_squared);
    return (1.0 + s) / (1.0 - s);
  };
  // The poles of the low-pass of third order: -1, and a conjugate pair of which one is enough.
  const std::complex<double> upper = std::polar(1.0, 2 * std::numbers::pi / 3);
  std::array pairs{BandPassPair(digital(-1.0, 1)), BandPassPair(digital(upper, 1)), BandPassPair(digital(upper, -1))};
  const double centre = 2 * std::atan(std::sqrt(centre_squared));
  for (BandPassPair& pair : pairs) pair.scale(1 / pair.gain(centre));
  return pairs;
}

}  // namespace

std::vector<ThirdOctave> third_octaves(double rate_Hz) {
  std::vector<ThirdOctave> bands;
  const double half_width = std::pow(10.0, 0.05);
  for (std::size_t i = 0; i < nominal_centres.size(); ++i) {
    const double centre = std::pow(10.0, 1 + 0.1 * static_cast<double>(i));
    if (centre * half_width >= highest_share_of_rate * rate_Hz) break;
    bands.push_back({nominal_centres[i], centre, centre / half_width, centre * half_width});
  }
  return bands;
}

std::vector<double> band_squares(std::span<const Vec3> x, const ThirdOctave& band, double rate_Hz) {
  TACTOR_DEMAND(band.low_Hz > 0 && band.high_Hz > band.low_Hz && band.high_Hz < 0.5 * rate_Hz);
  if (x.empty()) return {};
  std::array<BandPassPair, 3> pairs = band_pass(band.low_Hz, band.high_Hz, rate_Hz);
  const auto filtered = [&pairs](Vec3 v) {
    for (BandPassPair& pair : pairs) v = pair.step(v);
    return v;
  };
  const auto two_widths = static_cast<std::size_t>(std::ceil(2 * rate_Hz / (band.high_Hz - band.low_Hz)));
  const std::size_t pad = std::min(x.size() - 1, two_widths);
  // A constant does not pass, so taking the first value away starts the filter at rest.
  const Vec3 first = 2.0 * x.front() - x[pad];
  for (std::size_t i = pad; i > 0; --i) filtered(2.0 * x.front() - x[i] - first);
  std::vector<double> squares;
  squares.reserve(x.size());
  for (const Vec3& v : x) {
    const Vec3 y = filtered(v - first);
    squares.push_back(dot(y, y));
  }
  return squares;
}

}  // namespace tactor
