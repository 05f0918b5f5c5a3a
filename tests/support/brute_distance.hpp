// The distance to a mesh by a look at every face.
#pragma once

#include <algorithm>

#include "nodes/physics/mesh/mesh.hpp"

namespace tactor::test {

inline double segment_distance(const Vec3& a, const Vec3& b, const Vec3& x) {
  const double t = std::clamp(dot(x - a, b - a) / dot(b - a, b - a), 0.0, 1.0);
  return norm(x - a - t * (b - a));
}

/// To the nearest face, each by its plane and its edges.
inline double unsigned_distance(const TriangleMesh& mesh, const Vec3& x) {
  double least = 1e9;
  for (const auto& f : mesh.faces) {
    const Vec3 a = mesh.vertices[static_cast<std::size_t>(f[0])], b = mesh.vertices[static_cast<std::size_t>(f[1])],
               c = mesh.vertices[static_cast<std::size_t>(f[2])];
    const Vec3 n = cross(b - a, c - a) / norm(cross(b - a, c - a));
    const double height = dot(x - a, n);
    const Vec3 q = x - height * n;
    const bool within =
        dot(cross(b - a, q - a), n) >= 0 && dot(cross(c - b, q - b), n) >= 0 && dot(cross(a - c, q - c), n) >= 0;
    least = std::min(
        least, within ? std::abs(height)
                      : std::min({segment_distance(a, b, x), segment_distance(b, c, x), segment_distance(c, a, x)}));
  }
  return least;
}

}  // namespace tactor::test
