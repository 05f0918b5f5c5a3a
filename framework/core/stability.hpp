// Decides from the signals of a run whether it was stable: energy from nowhere, oscillation at rest, balance at rest.
#pragma once

#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "framework/core/spatial.hpp"

namespace tactor {

/// The verdict on a run; a larger number is worse. The numbers are those of the metric `stability.verdict`.
enum class StabilityVerdict : int {
  stable = 0,
  limit_cycle = 1,     ///< the tool kept oscillating when it should have been at rest
  pushed_through = 2,  ///< the tool rested where the static balance does not allow it
  energy = 3,          ///< energy came from nowhere
  not_finite = 4,      ///< a signal was NaN or infinite
  refused = 5,         ///< the run ended before it could be judged
};

/// `stable`, `limit_cycle`, ...
const char* name_of(StabilityVerdict verdict);

/// The largest rise and fall of a sequence: the smaller of its largest rise and its largest fall. It is zero for a
/// motion in one direction, and the peak-to-peak amplitude for a lasting oscillation.
class PeakToPeak {
 public:
  void see(double x);
  [[nodiscard]] double size() const { return std::min(rise_, fall_); }

 private:
  bool begun_ = false;
  double low_ = 0, high_ = 0, rise_ = 0, fall_ = 0;
};

/// The frequency in Hz of a sequence `x` at times `t` (s): from the times at which it crosses the line that fits it
/// best, where a crossing counts if the sequence then goes beyond a quarter of its largest distance from the line.
/// Zero where there are fewer than three of them, which are one period. `t` increases; both have the same length.
double oscillation_frequency(const std::vector<double>& t, const std::vector<double>& x);

/// An interval in which the tool should stand still.
struct StabilityRest {
  double begin = 0, end = 0;  ///< s
  std::optional<Vec3> p_WT;   ///< m, where static balance puts the tool, by the axes that `known` names
  Vec3 known{1, 1, 1};        ///< 1 or 0 an axis
  double tolerance = 1e-3;    ///< m, beyond which the tool was pushed through something
};

/// The limits beyond which a run counts as unstable.
struct StabilityLimits {
  double generated_share = 0.1;    ///< energy beyond what came in, as a share of all that came in
  double generated_min = 1e-6;     ///< J; less generated energy is ignored
  double peak_to_peak_max = 1e-6;  ///< m, at rest, from peak to peak
};

/// The signals at one instant.
struct StabilitySample {
  double t = 0;         ///< s
  Vec3 p_WT;            ///< m, the tool
  Vec3 arm{};           ///< m, its rotation vector from where it is to be, times a lever; zero where nothing turns
  double stored = 0;    ///< J, the energy that is known to be stored: kinetic, gravity, springs
  double given = 0;     ///< J, put in from outside since the sample before; negative where it was taken out
  double released = 0;  ///< J, not negative: what fell since the sample before, which is stored and counts as come in
  bool finite = true;   ///< false: a signal that is not among these was NaN or infinite
};

/// The verdict and the metrics behind it.
struct StabilityFinding {
  StabilityVerdict verdict = StabilityVerdict::stable;
  std::string reason;           ///< a sentence; empty where the run is stable
  double peak_energy_J = 0;     ///< the most that was stored
  double generated_J = 0;       ///< the largest surplus of what was stored over what had been put in: never negative
  double generated_share = 0;   ///< of all that came in; 0 where nothing came in
  double peak_to_peak_m = 0;    ///< there and back at rest, the largest
  double amplitude_m = 0;       ///< half of it
  double frequency_Hz = 0;      ///< of that oscillation; 0 where it has no whole period
  std::optional<double> off_m;  ///< from the balance at rest, the largest; absent where none is known
};

/// Sees the samples of a run in the order of time, the first at its beginning.
///
/// Energy from nowhere: `generated_J` is the largest value over time of stored(t) - stored(0) - given(0..t). A passive
/// system never has more than it was given; a system that generates energy by a hold, a delay or too long a step has.
/// The verdict is `energy` if this is more than `generated_min` and more than `generated_share` of all energy that came
/// in: energy given and not taken out, released by falling, and added by `add_stored`.
class StabilityJudge {
 public:
  explicit StabilityJudge(StabilityLimits limits, std::vector<StabilityRest> rests = {});

  /// Adds energy in J that was in the system at the beginning and that the samples lack, such as in contacts.
  void add_stored(double energy);
  /// False where a signal is not finite, from then on.
  bool see(const StabilitySample& sample);
  /// The run ended early, and why: its verdict is `refused`.
  void refuse(std::string why);
  [[nodiscard]] StabilityFinding finish() const;

 private:
  struct AtRest {
    PeakToPeak peak_to_peak[6];
    std::vector<double> t;
    std::vector<double> x[6];
    Vec3 last;
  };
  void see_rest(const StabilitySample& sample);
  void judge_rests(StabilityFinding& finding, bool& through) const;

  StabilityLimits limits_;
  std::vector<StabilityRest> rests_;
  std::vector<AtRest> at_rest_;
  bool begun_ = false, finite_ = true;
  double not_finite_at_ = 0;  // s
  std::string refusal_;
  double extra_ = 0;    // J, of add_stored
  double start_ = 0;    // J, stored at the beginning
  double given_ = 0;    // J, put in less taken out
  double came_in_ = 0;  // J, all that came in, at any time
  double surplus_ = 0, surplus_at_ = 0;
  double peak_ = -std::numeric_limits<double>::infinity();
};

}  // namespace tactor
