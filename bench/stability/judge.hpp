// Judges the states of a trial: energy, rest, balance.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <vector>

#include "bench/stability/stepper.hpp"

namespace tactor::bench {

/// The most that a sequence rises and falls again, or falls and rises: the smaller of its largest rise and its largest
/// fall. Zero for a motion in one direction, the height of a swing from peak to peak for one that goes on.
class Swing {
 public:
  void see(double x);
  [[nodiscard]] double size() const { return std::min(rise_, fall_); }

 private:
  bool begun_ = false;
  double low_ = 0, high_ = 0, rise_ = 0, fall_ = 0;
};

/// Sees every state of a trial in order.
/// Energy is kinetic energy, gravity and coupling spring; what came in is what the hand gave (force of spring and
/// damper times its way), what lay in the coupling, and what the first query's penetrations hold. The spring of a
/// contact is not counted: it only takes away, until it gives back. `generated` is the largest surplus as a share of
/// all that came in or fell down; beyond `generated_max` a cell has made energy.
class Judge {
 public:
  static constexpr double generated_max = 0.1;
  static constexpr double surplus_min = 1e-6;  ///< J, below which nothing is said of energy

  explicit Judge(const Trial& trial);

  /// The first query.
  void begin(const ContactSet& set);
  /// False where the state is not finite.
  bool see(const Reached& state);
  /// The verdict and the figures behind it.
  void finish(Finding& finding) const;

 private:
  struct AtRest {
    Swing swing[6];
    Vec3 last;
    bool seen = false;
  };
  [[nodiscard]] double energy(const Reached& state) const;

  const Trial& trial_;
  struct Inertia {
    double mass;
    Eigen::Matrix3d I_B;
  };
  std::vector<Inertia> bodies_;
  bool rotates_;
  std::vector<AtRest> rests_;
  Reached last_;
  bool begun_ = false, finite_ = true;
  double start_ = 0;    // J, energy at the beginning, contacts included
  double given_ = 0;    // J, by the hand
  double came_in_ = 0;  // J, all that came in, at any time
  double surplus_ = 0;  // J, largest
};

}  // namespace tactor::bench
