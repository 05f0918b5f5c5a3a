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

/// The body after h seconds without torque, from angular velocity `w_WB`, by implicit Euler in angular momentum L:
///   I_W(R') w' = L,   R' = exp(h w') R,
/// in as many equal parts as keep h |w| below 0.3 rad in each (64 at most). L is kept; energy does not grow.
Rotation free_rotation(const Eigen::Matrix3d& inertia_B, const Quat& R_WB, const Vec3& w_WB, double h);

}  // namespace tactor
