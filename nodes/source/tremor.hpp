// The tremor of a hand as a seeded sum of sinusoids: a function of time that does not depend on how often it is read.
#pragma once

#include <cstdint>
#include <vector>

#include "framework/core/spatial.hpp"

namespace tactor {

/// x(t) = a sum_i cos(2 pi f_i t + phi_i) for each axis, a = rms sqrt(2 / n), f_i uniform in [low, high], phi_i
/// uniform. Physiological tremor of the hand lies at 8-12 Hz (Elble and Koller 1990).
class Tremor {
 public:
  /// `rms` in m on each axis, the band in Hz, `components` sinusoids an axis.
  Tremor(double rms, double low, double high, int components, std::uint64_t seed);

  struct Value {
    Vec3 p;  ///< m
    Vec3 v;  ///< m/s
  };
  /// The excursion and its velocity at `t` (s).
  [[nodiscard]] Value at(double t) const;

 private:
  struct Component {
    Vec3 omega;  ///< rad/s
    Vec3 phase;  ///< rad
  };
  double amplitude_;
  std::vector<Component> components_;
};

}  // namespace tactor
