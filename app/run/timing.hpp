// How far run times can be trusted: a fixed computation between the runs, the spread of repeats, and the warning where
// a machine is not quiet.
#pragma once

#include <cstdint>
#include <limits>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

namespace tactor {

/// How runs are repeated for their run time.
struct Repeats {
  std::int64_t count = 1;    ///< runs whose median counts
  std::int64_t warm_up = 0;  ///< runs before these that do not
};
/// One run before them where there are several.
inline Repeats warmed_up(std::int64_t count) {
  return {count, count > 1 ? 1 : 0};
}

/// CPU time of this thread in us for a fixed computation of half a millisecond, which ought to take the same every
/// time.
double measure_control();

/// (longest - shortest) / median of the times of repeats. Not finite for fewer than two, and where the median is 0.
double spread_of_repeats(std::span<const double> times);
/// `12 %`, or `-` of what is not finite.
std::string percent(double share);

/// What the tables say of how the run times were taken and how far they can be trusted.
struct TimingNote {
  static constexpr double quiet_spread = 0.1;  ///< beyond this share it is warned of

  Repeats repeats;
  std::string text;
  std::string warning;       ///< or empty
  double spread_median = 0;  ///< over the runs, of the spread of their repeats; NaN without repeats
  double spread_worst = 0;   ///< the largest of them; NaN without repeats
  /// Of the fixed computation the median, and (95th - 5th percentile) / median; NaN without runs.
  double control_us = std::numeric_limits<double>::quiet_NaN();
  double control_spread = std::numeric_limits<double>::quiet_NaN();
};

/// How many of the runs have repeats that spread too far, and by how much at most; empty where none has. NaN is a run
/// without repeats.
std::string spread_warning(std::span<const double> spreads);

/// Of the times of the fixed computation and of the spreads of every run's repeats, NaN where there are none.
/// `of_repeats` is what the warning says of the repeats; what it says of the fixed computation is added. `anew` is
/// what the user may do then. Without any time it says nothing.
TimingNote timing_note(std::span<const double> control_us, std::span<const double> spreads, Repeats repeats,
                       const std::string& of_repeats, const std::string& anew = "measure anew on an idle machine");
nlohmann::ordered_json to_json(const TimingNote& note);
/// An empty line, then text and warning, each on a line behind `indent`; nothing where the note says nothing.
std::string lines_of(const TimingNote& note, const std::string& indent = "");

}  // namespace tactor
