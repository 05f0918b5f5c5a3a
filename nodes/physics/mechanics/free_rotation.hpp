// Rotation of a rigid body: its inertia in W, and how it turns while nothing acts on it.
#pragma once

#include <Eigen/Core>

#include "framework/core/spatial.hpp"

namespace tactor {

/// R_WB I_B R_WB^T, kg m^2.
Eigen::Matrix3d inertia_W(const Eigen::Matrix3d& inertia_B, const Quat& R_WB);

/// An orientation, and an angular velocity in rad/s in W.
struct Rotation {
  Quat R_WB;
  Vec3 w_WB;
};

/// The body after h seconds without torque, from angular velocity `w_WB`, by the midpoint rule in the body's frame:
///   I w' - I w = h (I W) x W,   W = (w + w') / 2,   R' = R cay(h W),
/// with cay(a) the turn about a by 2 atan(|a| / 2) (J. Simo, K. Wong, "Unconditionally stable algorithms for rigid body
/// dynamics that exactly preserve energy and momentum", 1991). It is in as many equal parts as keep h |w| below 0.3 rad
/// in each (64 at most). Angular momentum and kinetic energy are kept to rounding; the orientation is of second order
/// in h. If there is no solution for the inertia, the body keeps w.
Rotation free_rotation(const Eigen::Matrix3d& inertia_B, const Quat& R_WB, const Vec3& w_WB, double h);

}  // namespace tactor
