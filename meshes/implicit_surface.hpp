// Surfaces given by functions of space: meshed, and the functions to make bodies of.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>

#include "nodes/physics/mesh/mesh.hpp"

namespace tactor {

/// Negative inside a body, positive outside; lengths in m.
using ImplicitBody = double (*)(const Vec3& p);

/// How fine its surface is meshed before it is brought to its count.
struct ImplicitFineness {
  double within = 0;   ///< m, the radius of a ball about the origin that holds the body; the origin is inside
  double facets = 0;   ///< m, the largest radius of a facet's circumscribed circle
  double surface = 0;  ///< m, the largest distance of a facet from the surface
};

/// The surface by CGAL's surface mesher (Boissonnat and Oudot, "Provably good sampling and meshing of surfaces", 2005)
/// with a fixed seed, then with `faces` faces by decimate.hpp. Prints what was repaired.
TriangleMesh mesh_implicit(ImplicitBody body, const ImplicitFineness& fineness, std::size_t faces,
                           const std::string& name);

/// The smooth minimum of a and b: rounds the seam over about `blend`. From I. Quilez, "Smooth minimum" (polynomial).
inline double smooth_min(double a, double b, double blend) {
  const double t = std::max(blend - std::abs(a - b), 0.0) / blend;
  return std::min(a, b) - t * t * blend / 4;
}
/// The smooth maximum: what is inside a and outside b is smooth_max(a, -b, blend).
inline double smooth_max(double a, double b, double blend) {
  return -smooth_min(-a, -b, blend);
}

/// About the signed distance to an ellipsoid with these half axes, m.
inline double ellipsoid(const Vec3& p, const Vec3& center, const Vec3& half) {
  const Vec3 d = p - center;
  const double k0 = norm({d.x / half.x, d.y / half.y, d.z / half.z});
  const double k1 = norm({d.x / (half.x * half.x), d.y / (half.y * half.y), d.z / (half.z * half.z)});
  return k1 > 0 ? k0 * (k0 - 1) / k1 : -std::min({half.x, half.y, half.z});
}

}  // namespace tactor
