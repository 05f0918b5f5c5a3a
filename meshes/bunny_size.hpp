// The size that the bunny has here, however many triangles it has.
#pragma once

#include "nodes/physics/mesh/bounds.hpp"

namespace tactor {

/// Scales to a height of 0.15 m, along y as in the source, and centres the bounding box on the origin.
inline void bring_to_metres(TriangleMesh& mesh) {
  constexpr double height = 0.15;  // m
  const Bounds bounds = bounds_of(mesh);
  const double scale = height / bounds.size().y;
  for (Vec3& v : mesh.vertices) v = scale * (v - bounds.middle());
}

}  // namespace tactor
