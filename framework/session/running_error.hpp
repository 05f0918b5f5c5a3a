// The error and the delay of a displayed force against the true one, during a run.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "framework/core/felt.hpp"
#include "framework/core/messages.hpp"

namespace tactor {

/// What is known so far.
struct ErrorFigures {
  std::uint64_t compared = 0;     ///< samples
  Time until;                     ///< of the newest of them
  Duration covered;               ///< part of the run between compared samples
  double rms_N = 0;               ///< of |displayed - true|, over all
  double max_N = 0;               ///< the largest
  double rms_lately_N = 0;        ///< over the last second
  std::optional<Duration> delay;  ///< over the last two seconds; none where they do not tell it
};

/// What a hand is predicted to feel of the error of the last second.
struct FeltLately {
  double beyond_weber = 0;                 ///< share_beyond_weber()
  std::optional<FeltVibration> vibration;  ///< none where a second does not tell it
};

/// Compares the force of each displayed sample with the true one at the same time, linearly interpolated between true
/// samples. Both come in order of time.
class RunningError {
 public:
  void add_true(Time t, const Wrench& force);
  void add_displayed(Time t, const Wrench& force);
  /// Forgets the true force, because another one follows, and compares nothing before `from`.
  void begin_again(Time from);
  /// Restarts the statistics, and compares nothing before `from`.
  void count_anew(Time from);
  /// Compares all samples that can be compared.
  void compare();
  /// Takes about a millisecond, for the delay.
  [[nodiscard]] ErrorFigures figures() const;
  /// On a handle of so many kg; none where fewer than two samples were compared lately. Takes some milliseconds at 1
  /// kHz.
  [[nodiscard]] std::optional<FeltLately> felt(double handle_mass) const;

 private:
  struct Sample {
    Time t;
    Vec3 force;
  };
  [[nodiscard]] Vec3 true_at(Time t);

  std::deque<Sample> true_, displayed_;
  Time from_;
  // Of the last two seconds.
  std::deque<Time> times_;
  std::deque<Vec3> x_, reference_;
  std::uint64_t count_ = 0;
  Duration covered_;
  double sum_of_squares_ = 0, largest_ = 0;
};

}  // namespace tactor
