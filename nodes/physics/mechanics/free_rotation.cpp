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

/// The mean angular velocity W of a step in the body's frame: the root of I W + h/2 W x I W - L_B, by Newton's method.
Vector3d mean_velocity(const Matrix3d& inertia_B, const Vector3d& L_B, const Vector3d& start, double h) {
  Vector3d W = start;
  for (int i = 0; i < 20; ++i) {
    const Vector3d L = inertia_B * W;
    const Vector3d residual = L + h / 2 * W.cross(L) - L_B;
    const Matrix3d jacobian = inertia_B + h / 2 * (skew(W) * inertia_B - skew(L));
    const Vector3d change = jacobian.inverse() * residual;
    if (!change.allFinite()) return start;
    W -= change;
    if (change.squaredNorm() <= 1e-32 * W.squaredNorm()) break;
  }
  return W;
}

}  // namespace

Rotation free_rotation(const Matrix3d& inertia_B, const Quat& R_WB, const Vec3& w_WB, double h) {
  const Vector3d w_B = eigen(rotate(inverse(R_WB), w_WB));
  const Vector3d L_B = inertia_B * w_B;
  const double turn = h * w_B.norm();
  if (h * w_B.cross(L_B).norm() <= 1e-16 * L_B.norm()) {  // about a principal axis
    return {normalized(from_rotation_vector(h * w_WB) * R_WB), w_WB};
  }
  // What is no number or too large gets the most parts.
  const int parts = turn < 19 ? std::max(1, static_cast<int>(std::ceil(turn / 0.3))) : 64;
  const double part = h / parts;
  const Vec3 L_W = rotate(R_WB, plain(L_B));
  Quat R = R_WB;
  Vector3d w = w_B;
  for (int i = 0; i < parts; ++i) {
    const Vector3d W = mean_velocity(inertia_B, eigen(rotate(inverse(R), L_W)), w, part);
    w = 2 * W - w;
    // Cayley's map: a turn about W with tan(angle / 2) = part |W| / 2.
    R = normalized(R * Quat{1, part / 2 * W.x(), part / 2 * W.y(), part / 2 * W.z()});
  }
  return {R, rotate(R, plain(w))};
}

}  // namespace tactor
