#include "nodes/physics/mechanics/free_rotation.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "nodes/physics/mechanics/eigen.hpp"

namespace tactor {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Matrix3d inertia_W(const Matrix3d& inertia_B, const Quat& R_WB) {
  const Matrix3d R = matrix(R_WB);
  return R * inertia_B * R.transpose();
}

namespace {

/// The new angular velocity in the body's frame: the root of I w - exp(-h w) L_B, by Newton's method.
Vector3d implicit_velocity(const Matrix3d& inertia_B, const Vector3d& L_B, const Vector3d& start, double h) {
  Vector3d w = start;
  for (int i = 0; i < 20; ++i) {
    const Vector3d turned = eigen(rotate(from_rotation_vector(plain(-h * w)), plain(L_B)));
    const Vector3d residual = inertia_B * w - turned;
    // exp(-h (w + d)) L = exp(-h w) L + h [exp(-h w) L]x d, but for terms of higher order in h w.
    const Matrix3d jacobian = inertia_B - h * skew(turned);
    const Vector3d change = jacobian.inverse() * residual;
    if (!change.allFinite()) return start;
    w -= change;
    if (change.squaredNorm() <= 1e-32 * w.squaredNorm()) break;
  }
  return w;
}

}  // namespace

Rotation free_rotation(const Matrix3d& inertia_B, const Quat& R_WB, const Vec3& w_WB, double h) {
  const Vector3d w_B = eigen(rotate(inverse(R_WB), w_WB));
  const Vector3d L_B = inertia_B * w_B;
  const double turn = h * w_B.norm();
  if (h * w_B.cross(L_B).norm() <= 1e-16 * L_B.norm()) {  // about a principal axis
    return {normalized(from_rotation_vector(h * w_WB) * R_WB), w_WB};
  }
  const Vec3 L_W = rotate(R_WB, plain(L_B));
  // What is no number or too large gets the most parts.
  const int parts = turn < 19 ? std::max(1, static_cast<int>(std::ceil(turn / 0.3))) : 64;
  Rotation now{R_WB, w_WB};
  for (int i = 0; i < parts; ++i) {
    const Quat to_B = inverse(now.R_WB);
    const Vector3d w = implicit_velocity(inertia_B, eigen(rotate(to_B, L_W)), eigen(rotate(to_B, now.w_WB)), h / parts);
    // Rotating about w keeps w, so that it has the same components in the frame before and after.
    now.w_WB = rotate(now.R_WB, plain(w));
    now.R_WB = normalized(from_rotation_vector((h / parts) * now.w_WB) * now.R_WB);
  }
  return now;
}

}  // namespace tactor
