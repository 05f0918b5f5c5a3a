// The velocity of a handle from what its encoders show: filters of several kinds of motion, mixed by what a hand feels.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "framework/core/spatial.hpp"
#include "framework/realtime/likelihood.hpp"
#include "framework/realtime/motion_filter.hpp"
#include "framework/realtime/steady_model.hpp"

namespace tactor {

/// 24 kinds of motion, with d the departure:
///   - the twelve chains of MotionFilter,
///   - tremors of 7, 10 and 14 Hz with an RMS of 25 d at 10 Hz, the less the faster, and one of 10 Hz with 75 d, all on
///     a hand that moves as a chain of departure d, and all on one of d/10,
///   - a tremor of 19 Hz with 60 d,
///   - broad motions around 6 to 20 Hz with 10, 40 and 160 d.
/// Those of tremor and broad motion are left out where samples come too slowly for them, or not evenly: then it tells
/// what MotionFilter tells.
///
/// Each kind i is as likely, axis by axis, as it made the samples of the last 0.1 s (FadingLikelihood). A force is
/// k p + b v. For each i there is one best sum of all filters' estimates,
///   sum_j M_ij (k p_j + b v_j),   sum_j M_ij = 1,
/// whose error is least if the motion is i's: its mean square, plus a multiple of the mean square of W times the
/// error, by the spectra of motion and noise. W tells what a hand feels as vibration: up to 160 Hz it is the inverse of
/// vibration_force_threshold(). Above, it grows with frequency, so that second differences stay small. Broad motions
/// and the tremor of 19 Hz have a slow motion beside them. The result is the mean of these sums, each by how likely its
/// i is.
///
/// A coupling has the position as the encoder shows it, and only the velocity from here. Sums that are best for that
/// force were tried: they have more error where steps are 10 um.
///
/// So a calm motion is shown without the vibration that an encoder's steps make, and a fast one with the least error.
class MixedFilter {
 public:
  static constexpr std::size_t models = 24;
  static constexpr std::size_t chains = MotionFilter::models;

  /// The longest nominal interval, s: slower samples cannot show the vibration that is mixed away.
  static constexpr double longest = 4e-3;

  /// `departure` in 10 ms, of the second model; `noise`: standard deviation of a sample, m or rad; `nominal`: the
  /// interval between samples, s, up to `longest`. All above zero.
  MixedFilter(double departure, double noise, double nominal);

  void start(const Vec3& value);
  /// Takes in a sample that is `interval` > 0 s later than the last.
  void take(double interval, const Vec3& sample);
  /// From here on values are counted from `value`.
  void count_from(const Vec3& value);

  [[nodiscard]] const Vec3& value() const { return value_; }
  [[nodiscard]] const Vec3& rate() const { return rate_; }
  /// False within 0.1 s of an uneven interval: then it tells what MotionFilter tells.
  [[nodiscard]] bool mixes() const;

 private:
  void mix();

  double nominal_;
  MotionFilter chains_;
  std::vector<SteadyModel> tremors_;                         // tremors and broad motions
  std::array<std::array<double, models>, models> mixing_{};  // M
  FadingLikelihood<models> likelihood_;
  double even_for_ = 0;  // s, that intervals were near the nominal one
  Vec3 value_, rate_;
};

}  // namespace tactor
