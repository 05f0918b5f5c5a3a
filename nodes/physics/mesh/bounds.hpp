// The smallest box along the axes about some points.
#pragma once

#include <algorithm>
#include <limits>

#include "nodes/physics/mesh/mesh.hpp"

namespace tactor {

struct Bounds {
  Vec3 low{infinity, infinity, infinity}, high{-infinity, -infinity, -infinity};  ///< m

  void add(const Vec3& p) {
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], p[axis]);
      high[axis] = std::max(high[axis], p[axis]);
    }
  }
  [[nodiscard]] Vec3 size() const { return high - low; }
  [[nodiscard]] Vec3 middle() const { return 0.5 * (low + high); }
  [[nodiscard]] double longest() const { return std::max({size().x, size().y, size().z}); }  ///< m, of the edges
  [[nodiscard]] int longest_axis() const {
    const Vec3 s = size();
    return s.x >= s.y && s.x >= s.z ? 0 : s.y >= s.z ? 1 : 2;
  }

 private:
  static constexpr double infinity = std::numeric_limits<double>::infinity();
};

inline Bounds bounds_of(const TriangleMesh& mesh) {
  Bounds bounds;
  for (const Vec3& v : mesh.vertices) bounds.add(v);
  return bounds;
}

}  // namespace tactor
