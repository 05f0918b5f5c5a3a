// What a force gives on its way down to zero, and how much of it the energy that is there allows.
#pragma once

#include <cmath>

namespace tactor {

/// J that a force of `size` N gives while it ramps down by `step` N a tick, from its second tick on, where the handle
/// goes `along` m with it in the first tick, and in each further one `more` m farther: the sum of (size - k step)
/// max(0, along + k more) over k = 1, 2, ... as long as something is left. Between whole numbers of ticks it is their
/// polynomial.
inline double given_on_ramp(double size, double step, double along, double more) {
  if (along < 0) {
    // It comes down while the handle goes on against it.
    if (!(size * more > -along * step)) return 0;
    size += along / more * step;
    along = 0;
  }
  const double ticks = size / step;
  if (ticks <= 1) return 0;
  return 0.5 * step * ticks * (ticks - 1) * (along + more * (ticks + 1) / 3);
}

/// The largest share s of a force, 1 at most, with s given + s^2 ramp <= energy; all in J.
inline double share_within(double given, double ramp, double energy) {
  if (given + ramp <= energy) return 1;
  return energy > 0 ? 2 * energy / (given + std::sqrt(given * given + 4 * ramp * energy)) : 0;
}

}  // namespace tactor
