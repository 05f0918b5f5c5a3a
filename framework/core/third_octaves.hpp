// How much of a sampled signal lies in each third of an octave from 10 to 500 Hz.
#pragma once

#include <span>
#include <vector>

#include "framework/core/spatial.hpp"

namespace tactor {

/// One third of an octave, a tenth of a decade: from centre 10^(-1/20) to centre 10^(1/20).
struct ThirdOctave {
  double nominal_Hz;  ///< what tables call it: 31.5 for 10^1.5
  double centre_Hz, low_Hz, high_Hz;
};

/// The bands from 10 to 500 Hz, but only those whose upper edge is under 0.45 of the `rate_Hz` of samples.
std::vector<ThirdOctave> third_octaves(double rate_Hz);

/// |y_i|^2 of the part y of a signal that lies in the band: through a Butterworth band-pass of third order (six poles,
/// by the bilinear transform, -3 dB at the edges, gain 1 at their geometric mean). Before its begin the signal goes on
/// as its reflection through the first sample (x_{-i} = 2 x_0 - x_i), for two divided by the bandwidth at most, where
/// the filter starts at rest. The band's upper edge is under half of `rate_Hz`.
std::vector<double> band_squares(std::span<const Vec3> x, const ThirdOctave& band, double rate_Hz);

}  // namespace tactor
