// Dry friction of a device: it holds at rest up to a breakaway level and slows what moves.
#pragma once

#include "framework/core/spatial.hpp"

namespace tactor {

/// The levels in N, or N m for rotation; the Stribeck velocity in m/s, or rad/s.
struct FrictionParameters {
  double coulomb = 0;            ///< at speeds far above the Stribeck velocity; usual: 0.02 N to 0.3 N
  double breakaway = 0;          ///< that holds a body at rest; counts where it is above `coulomb`
  double stribeck_velocity = 0;  ///< by which most of the difference is gone; usual: 1 mm/s to 20 mm/s
};

/// Against the velocity v of the body, relative to the world:
///   F(v) = (F_c + (F_s - F_c) exp(-(v / v_s)^2)) v / |v|,
/// with F_c the Coulomb level, F_s the breakaway level and v_s the Stribeck velocity: the usual static model of Coulomb
/// friction, breakaway and Stribeck effect. At rest it balances any force up to F_s. Isotropic: it depends on |v|.
class Friction {
 public:
  explicit Friction(const FrictionParameters& parameters);

  /// |F| at a speed above 0.
  [[nodiscard]] double level(double speed) const noexcept;
  /// F_s: what a body at rest holds.
  [[nodiscard]] double holds() const noexcept { return falls_ ? parameters_.breakaway : parameters_.coulomb; }
  /// True where a body at rest is held more firmly than one that slides.
  [[nodiscard]] bool has_breakaway() const noexcept { return falls_; }
  /// The velocity `v` after `h` s of friction alone on `inertia`; it comes to rest and never turns round. Exact where
  /// F is constant; else by the midpoint rule, with an error of order h^3.
  [[nodiscard]] Vec3 slowed(const Vec3& v, double h, double inertia) const noexcept;

 private:
  FrictionParameters parameters_;
  bool falls_;  // F depends on the speed
};

}  // namespace tactor
