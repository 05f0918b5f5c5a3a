// The mechanics of an emulated device: its arm, and the hand that moves it.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "framework/core/spatial.hpp"

namespace tactor {

/// The geometry of an arm: where the handle is, and how it moves with each axis.
class ArmGeometry {
 public:
  virtual ~ArmGeometry() = default;
  [[nodiscard]] virtual int axes() const = 0;
  /// p_BD in m and the columns of J = dp/dq at q; false where the arm cannot be there.
  [[nodiscard]] virtual bool at(const std::array<double, 6>& q, Vec3& p_BD, std::array<Vec3, 6>& J) const = 0;
  /// The q at which the handle is there; false beyond reach.
  [[nodiscard]] virtual bool reach(const Vec3& p_BD, std::array<double, 6>& q) const = 0;
};

/// `linear` with a direction an axis (at right angles), `wooden` with La, Lb, Lc, O, or `delta` with the Falcon's
/// lengths as they are published (`numbers` is then empty). Null for any other.
std::unique_ptr<ArmGeometry> make_arm_geometry(const std::string& kind, const std::vector<double>& numbers);

/// A hand on the handle.
struct HandModel {
  double mass = 0.6;          ///< kg, of handle and hand
  double damping = 6.5;       ///< N s/m, between hand and its target
  double stiffness = 135;     ///< N/m, the same
  double friction = 0.2;      ///< N s/m, viscous, of the handle
  double hold = 0.5;          ///< s, in which the hand keeps the handle where it began
  double approach = 1.0;      ///< s, from there to the path
  std::vector<double> times;  ///< s, of the path, rising; after its last point it begins anew
  std::vector<Vec3> points;   ///< m, in the base
};

/// Axis by axis m |J_i|^2 q_i'' = tau_i + J_i . F, with the hand's force on the handle
/// F = k (x_h - x) + b (v_h - v) - c v, in steps of 0.1 ms at most. The inertia that axes share is left out.
class EmulatedArm {
 public:
  EmulatedArm(std::unique_ptr<ArmGeometry> geometry, HandModel hand);

  /// The handle stands still there, and the hand's time begins anew. False beyond reach.
  bool place(const Vec3& p_BD);
  void advance(double dt, const std::array<double, 6>& torque);

  [[nodiscard]] int axes() const { return geometry_->axes(); }
  [[nodiscard]] const std::array<double, 6>& q() const { return q_; }
  [[nodiscard]] const Vec3& p_BD() const { return p_; }
  /// J, net, that the torques have given since `place`.
  [[nodiscard]] double given() const { return given_; }
  /// Where the hand wants the handle at a time after `place`.
  [[nodiscard]] Vec3 target(double time) const;

 private:
  void step(double dt, const std::array<double, 6>& torque);
  [[nodiscard]] Vec3 on_path(double time) const;

  std::unique_ptr<ArmGeometry> geometry_;
  HandModel hand_;
  Vec3 start_, p_;
  std::array<Vec3, 6> J_{};
  std::array<double, 6> q_{}, rate_{};
  double time_ = 0;
  double given_ = 0;  // J
};

}  // namespace tactor
