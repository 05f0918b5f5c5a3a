// Compares two sampled force signals: error, delay, smoothness, share of the error that can be felt.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "framework/core/spatial.hpp"

namespace tactor {

// Signals are vectors at a uniform step; N stands for their unit (N m where they are torques). Two signals that are
// compared have the same length and the same times. An empty or too short signal gives 0.

/// Root of the mean of the squared values.
double rms(std::span<const double> x);
/// Root of the mean of |x_i|^2.
double rms(std::span<const Vec3> x);
/// Root of the mean of |x_i - reference_i|^2.
double rms_error(std::span<const Vec3> x, std::span<const Vec3> reference);
/// The largest |x_i - reference_i|.
double max_error(std::span<const Vec3> x, std::span<const Vec3> reference);

/// Differences of a signal.
struct Smoothness {
  double rms_d1 = 0;    ///< N/ms, of (x_i - x_{i-1}) / step
  double rms_d2 = 0;    ///< N/ms^2, of (x_{i+1} - 2 x_i + x_{i-1}) / step^2
  double max_step = 0;  ///< N, the largest |x_i - x_{i-1}|
};
/// `step_ms` in ms.
Smoothness smoothness(std::span<const Vec3> x, double step_ms);

/// RMS of the part of `x` above `cutoff_hz`: through a Butterworth high-pass of fourth order (bilinear, -3 dB at the
/// cutoff) forwards and then backwards, so without a shift. A wave of frequency f keeps the share
/// 1 / (1 + (tan(pi cutoff / rate) / tan(pi f / rate))^8) of its amplitude. Beyond its ends the signal goes on as its
/// reflection through the end point (x_{-i} = 2 x_0 - x_i), for three periods of the cutoff at most. `rate_hz` samples
/// a second, more than twice the cutoff.
double rms_above(std::span<const Vec3> x, double cutoff_hz, double rate_hz);

/// By how many steps `x` is behind `reference`: the lag of the largest normalised cross-correlation
/// sum_i x_{i+l} . r_i / sqrt(sum_i |x_{i+l}|^2 sum_i |r_i|^2) within +-max_lag, refined by the parabola through the
/// peak and its neighbours. For each lag the sums are over the samples that overlap, less their means, so that a signal
/// merely shifted by whole steps correlates by exactly 1. Positive: x is late. Empty if a signal is constant or has no
/// more than 2 max_lag samples. A peak needs a neighbour on either side that is no higher, so the ends of the range are
/// not peaks. Of the peaks within 2 % of the highest correlation, the one nearest to zero counts: a tremor correlates
/// again after each of its periods, and this must not count as a delay of a period. Without a peak: empty.
std::optional<double> delay_steps(std::span<const Vec3> x, std::span<const Vec3> reference, std::int64_t max_lag);

/// By how many steps `x` is behind `reference`: delay_steps of the changes of both within `change` steps. Distant parts
/// of a slowly rising force are alike, but their changes are not.
inline constexpr double delay_change_time_s = 0.02;  ///< which `change` stands for wherever a delay is told
std::optional<double> delay_of_changes(std::span<const Vec3> x, std::span<const Vec3> reference, std::int64_t max_lag,
                                       std::int64_t change);

/// Whether a delay by `late` steps explains the difference of x from the reference: the RMS difference of x from the
/// shifted reference is less than half of the reference's RMS variation about its mean.
bool is_explained_by(double late, std::span<const Vec3> x, std::span<const Vec3> reference);

/// The share of samples with |x_i - reference_i| > max(floor, fraction |reference_i|).
double share_beyond(std::span<const Vec3> x, std::span<const Vec3> reference, double floor, double fraction);

/// The force displayed after contact was lost.
struct AfterLoss {
  double overshoot = 0;  ///< the largest force towards the surface, beyond what the reference itself has
  double ghost = 0;      ///< the largest force still in the old direction in the second half of the window, when a
                         ///< merely late force has passed
};

/// Contact is lost at i where |reference| falls to `threshold` or under; the direction d of reference_{i-1} is away
/// from the surface. Over the `window` samples j from i on, as long as the reference stays under the threshold, the
/// overshoot is the largest max(0, -x_j . d) - max(0, -reference_j . d), and the ghost the largest (x_j - reference_j)
/// . d. So a force that vanishes before the reference does is no overshoot. Nothing where contact is never lost.
std::optional<AfterLoss> after_loss(std::span<const Vec3> x, std::span<const Vec3> reference, double threshold,
                                    std::int64_t window);

}  // namespace tactor
