// One cell of a map of stability: what is set, and what was found.
#pragma once

#include <cstdint>
#include <limits>
#include <string>

#include "framework/core/stability.hpp"

namespace tactor::bench {

/// The four things that a map varies.
struct Cell {
  double contact_stiffness = 0;   ///< N/m of the whole surface in contact
  double mass = 0;                ///< kg, of the tool
  double rate = 0;                ///< Hz, of physics
  double coupling_stiffness = 0;  ///< N/m
};

/// The metrics behind a verdict.
struct Finding {
  static constexpr double none = std::numeric_limits<double>::quiet_NaN();
  StabilityVerdict verdict = StabilityVerdict::stable;
  double generated = none;         ///< the most energy beyond what came in, as a share of what came in
  double peak_to_peak = none;      ///< m, there and back at rest
  double rest_error = none;        ///< m, from the static balance where it is known
  double step_s = 0;               ///< s, in the stepper
  double query_s = 0;              ///< s, in contact queries
  int left_out = 0;                ///< contacts at most that a query found and its set did not hold
  double simulated_s = 0;          ///< s
  std::int64_t damped_steps = 0;   ///< of ours, not converged and taken as one damped linear step
  std::int64_t stopped_steps = 0;  ///< of ours, not solved at all
  std::string why;                 ///< of a stepper that gave up
};

}  // namespace tactor::bench
