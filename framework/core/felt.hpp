// What of the error of a displayed force a hand notices: as a wrong force, and as vibration.
#pragma once

#include <optional>
#include <span>

#include "framework/core/spatial.hpp"

namespace tactor {

/// The share of samples with |x_i - reference_i| > force_jnd(|reference_i|), N; what is not finite counts. 0 of none.
double share_beyond_weber(std::span<const Vec3> x, std::span<const Vec3> reference);

/// Vibration of an error of force over the threshold of its band, 0 dB: RMS of the band as strong as the weakest
/// sinusoid that is felt.
struct FeltVibration {
  double mean_dB = 0;   ///< the highest band, by RMS over all samples
  double mean_Hz = 0;   ///< which band that is, by its nominal centre; 0 of none
  double worst_dB = 0;  ///< the highest band of the worst half second
};

/// Of errors x_i - reference_i in N, `rate_Hz` samples a second, on a handle of `handle_mass` kg. Levels are never told
/// under -100 dB. Nothing where the samples cover less than half a second, one is not finite, or the rate leaves no
/// band.
std::optional<FeltVibration> felt_vibration(std::span<const Vec3> x, std::span<const Vec3> reference, double rate_Hz,
                                            double handle_mass);

}  // namespace tactor
