// The force ripple of motors: a force that depends on where the handle is.
#pragma once

#include "framework/core/spatial.hpp"

namespace tactor {

struct CoggingParameters {
  double force = 0;      ///< N, the amplitude of each axis; usual: 0.01 N to 0.1 N at the handle
  double period = 5e-3;  ///< m, from one rest position to the next, above 0
};

/// Per axis x of W, with amplitude A and period P:
///   F(x) = -A sin(2 pi x / P), the gradient of the potential U(x) = -(A P / 2 pi) cos(2 pi x / P), with the sign
///   turned.
/// So it takes as much energy on the way up as it gives on the way down, and none over a closed path. The rest
/// positions are the multiples of P.
class Cogging {
 public:
  explicit Cogging(const CoggingParameters& parameters);

  [[nodiscard]] bool acts() const noexcept { return amplitude_ > 0; }
  /// On a body at `p_WD`, m; N in W.
  [[nodiscard]] Vec3 force(const Vec3& p_WD) const noexcept;
  /// J; zero halfway up from a rest position.
  [[nodiscard]] double energy(const Vec3& p_WD) const noexcept;
  /// N/m, the steepest slope of the force.
  [[nodiscard]] double stiffness() const noexcept { return amplitude_ * wave_number_; }

 private:
  double amplitude_;    // N
  double wave_number_;  // rad/m
};

}  // namespace tactor
