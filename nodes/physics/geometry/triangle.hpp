// The nearest point of one triangle.
#pragma once

#include <array>

#include "nodes/physics/geometry/signed_distance.hpp"

namespace tactor {

/// A point of a triangle: on its face, or on edge i (from corner i to i + 1), or at corner i.
struct OnTriangle {
  Vec3 p;  ///< m
  Feature feature = Feature::face;
  std::uint8_t i = 0;
};

/// The nearest point of a triangle to x (C. Ericson, "Real-Time Collision Detection", section 5.1.5).
inline OnTriangle nearest_on(const std::array<Vec3, 3>& corner, const Vec3& x) {
  const Vec3 &a = corner[0], &b = corner[1], &c = corner[2];
  const Vec3 ab = b - a, ac = c - a, ax = x - a, bx = x - b, cx = x - c;
  const double d1 = dot(ab, ax), d2 = dot(ac, ax), d3 = dot(ab, bx), d4 = dot(ac, bx), d5 = dot(ab, cx),
               d6 = dot(ac, cx);
  if (d1 <= 0 && d2 <= 0) return {a, Feature::corner, 0};
  if (d3 >= 0 && d4 <= d3) return {b, Feature::corner, 1};
  if (d6 >= 0 && d5 <= d6) return {c, Feature::corner, 2};
  const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {a + d1 / (d1 - d3) * ab, Feature::edge, 0};
  if (va <= 0 && d4 >= d3 && d5 >= d6) {
    return {b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b), Feature::edge, 1};
  }
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {a + d2 / (d2 - d6) * ac, Feature::edge, 2};
  const double scale = 1 / (va + vb + vc);
  return {a + vb * scale * ab + vc * scale * ac, Feature::face, 0};
}

}  // namespace tactor
