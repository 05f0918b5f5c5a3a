// Between the plain vectors of messages and Eigen's.
#pragma once

#include <Eigen/Core>

#include "framework/core/spatial.hpp"

namespace tactor {

inline Eigen::Vector3d eigen(const Vec3& v) {
  return {v.x, v.y, v.z};
}
inline Vec3 plain(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

/// [v]x, with [v]x u = v x u.
inline Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

inline Eigen::Matrix3d matrix(const Quat& q) {
  Eigen::Matrix3d m;
  m << 1 - 2 * (q.y * q.y + q.z * q.z), 2 * (q.x * q.y - q.w * q.z), 2 * (q.x * q.z + q.w * q.y),  //
      2 * (q.x * q.y + q.w * q.z), 1 - 2 * (q.x * q.x + q.z * q.z), 2 * (q.y * q.z - q.w * q.x),   //
      2 * (q.x * q.z - q.w * q.y), 2 * (q.y * q.z + q.w * q.x), 1 - 2 * (q.x * q.x + q.y * q.y);
  return m;
}

}  // namespace tactor
