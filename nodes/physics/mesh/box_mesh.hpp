// A box as triangles.
#pragma once

#include <array>

#include "nodes/physics/mesh/mesh.hpp"

namespace tactor {

/// Closed, outward, its middle at the origin; `size` in m along x, y, z.
inline TriangleMesh box_mesh(const Vec3& size) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.push_back({((i & 1) != 0 ? 0.5 : -0.5) * size.x, ((i & 2) != 0 ? 0.5 : -0.5) * size.y,
                             ((i & 4) != 0 ? 0.5 : -0.5) * size.z});
  }
  constexpr std::array<std::array<int, 4>, 6> sides{
      {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
  for (const auto& [a, b, c, d] : sides) {
    mesh.faces.push_back({a, b, c});
    mesh.faces.push_back({a, c, d});
  }
  return mesh;
}

}  // namespace tactor
