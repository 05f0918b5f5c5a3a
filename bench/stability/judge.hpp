// Tells the judge of stability the states of a trial: their energy, and what the hand gave.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "bench/stability/stepper.hpp"
#include "framework/core/stability.hpp"

namespace tactor::bench {

/// Sees every state of a trial in order.
/// Energy is kinetic energy, gravity and coupling spring; what came in is what the hand gave (force of spring and
/// damper times its way), what lay in the coupling, and what the first query's penetrations hold. The spring of a
/// contact is not counted: it only takes away, until it gives back.
class Judge {
 public:
  explicit Judge(const Trial& trial);

  /// The first query.
  void begin(const ContactSet& set);
  /// False where the state is not finite.
  bool see(const Reached& state);
  /// The verdict and the metrics behind it.
  void finish(Finding& finding) const;

 private:
  [[nodiscard]] double energy(const Reached& state) const;
  [[nodiscard]] double given(const Reached& state) const;
  [[nodiscard]] bool is_finite_state(const Reached& state) const;

  const Trial& trial_;
  struct Inertia {
    double mass;
    Eigen::Matrix3d I_B;
  };
  std::vector<Inertia> bodies_;
  bool rotates_;
  StabilityJudge judge_;
  Reached last_;
  bool begun_ = false;
};

}  // namespace tactor::bench
