// The geometry of WoodenHaptics and Polhem: a turning base with two links that are driven from it.
#pragma once

#include <array>
#include <optional>

#include "framework/core/spatial.hpp"

namespace tactor {

/// Three angles in rad: A turns the base about z, B and C lean the upper and the lower link, each against the vertical.
/// With the handle D at the end of the lower link and O a point in the middle of the workspace,
///   x = cos A (Lb sin B + Lc sin C) - O_x
///   y = sin A (Lb sin B + Lc sin C) - O_y
///   z = La + Lb cos B - Lc cos C - O_z
/// as published with the device (J. Forsslund, haptikfabrikenapi, src/kinematics.cpp, configuration polhem_v1).
struct WoodenGeometry {
  double La = 0.058, Lb = 0.174, Lc = 0.133;  ///< m
  Vec3 O{0.140, 0, 0.100};                    ///< m
};

class WoodenArm {
 public:
  explicit WoodenArm(const WoodenGeometry& geometry = {}) : g_(geometry) {}

  /// Where the handle is, p_BD in m.
  [[nodiscard]] Vec3 forward(const std::array<double, 3>& q) const;
  /// The columns of J = dp/dq, m/rad; the torques of a force are J^T F.
  [[nodiscard]] std::array<Vec3, 3> jacobian(const std::array<double, 3>& q) const;
  /// The angles at which the handle is there, with the elbow up and the handle before the base; nothing beyond reach.
  [[nodiscard]] std::optional<std::array<double, 3>> inverse(const Vec3& p_BD) const;

 private:
  WoodenGeometry g_;
};

}  // namespace tactor
