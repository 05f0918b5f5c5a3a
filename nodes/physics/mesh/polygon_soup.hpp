// What a mesh file lists: points, and polygons that refer to them.
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "framework/core/spatial.hpp"

namespace tactor {

/// Points and polygons as they stand in a file, in its unit and frame. Nothing is known of how polygons meet. What a
/// reader returns has finite coordinates, three corners or more in a polygon, and indices in range.
struct PolygonSoup {
  std::vector<Vec3> points;
  std::vector<std::vector<std::size_t>> polygons;
};

/// Bytes that a polygon of so many corners takes, with what the heap keeps of it.
constexpr std::size_t polygon_bytes(std::size_t corners) {
  return sizeof(std::vector<std::size_t>) + 16 + corners * sizeof(std::size_t);
}

/// False for what is not a number, infinite, or so far out that products of coordinates overflow.
inline bool is_usable(const Vec3& point) {
  constexpr double most = 1e15;
  return std::abs(point.x) <= most && std::abs(point.y) <= most && std::abs(point.z) <= most;
}

}  // namespace tactor
