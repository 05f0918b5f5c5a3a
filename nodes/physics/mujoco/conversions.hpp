// MuJoCo's numbers as ours.
#pragma once

#include <mujoco/mujoco.h>

#include "framework/core/spatial.hpp"

namespace tactor {

inline Vec3 vec3_at(const double* v) {
  return {v[0], v[1], v[2]};
}

/// The centre of mass of a body, m, and the orientation of its frame, in W.
inline Pose centre_pose(const mjData& d, int body) {
  const double* q = d.xquat + 4 * body;
  return {vec3_at(d.xipos + 3 * body), {q[0], q[1], q[2], q[3]}};
}

}  // namespace tactor
