#include "nodes/physics/mesh/tet_quality.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

/// Twice the area of each face times its outward unit normal; face i lies opposite to corner i.
std::array<Vec3, 4> face_normals(const TetCorners& p) {
  return {cross(p[2] - p[1], p[3] - p[1]), cross(p[3] - p[0], p[2] - p[0]), cross(p[1] - p[0], p[3] - p[0]),
          cross(p[2] - p[0], p[1] - p[0])};
}

}  // namespace

double volume_of(const TetCorners& tet) {
  return dot(tet[1] - tet[0], cross(tet[2] - tet[0], tet[3] - tet[0])) / 6;
}

DihedralAngles dihedral_angles(const TetCorners& tet) {
  const std::array<Vec3, 4> normals = face_normals(tet);
  DihedralAngles angles{std::numbers::pi, 0};
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = i + 1; j < 4; ++j) {
      // The faces opposite to i and j meet at the angle pi less that of their outward normals.
      const Vec3 &a = normals[i], &b = normals[j];
      const double angle = std::numbers::pi - std::atan2(norm(cross(a, b)), dot(a, b));
      angles.smallest = std::min(angles.smallest, angle);
      angles.largest = std::max(angles.largest, angle);
    }
  }
  return angles;
}

double radius_ratio(const TetCorners& tet) {
  const Vec3 a = tet[1] - tet[0], b = tet[2] - tet[0], c = tet[3] - tet[0];
  double doubled_area = 0;
  for (const Vec3& normal : face_normals(tet)) doubled_area += norm(normal);
  // r = 3 V / area and R = |w| / (12 V) with w as below.
  const double volume = volume_of(tet);
  const Vec3 w = dot(a, a) * cross(b, c) + dot(b, b) * cross(c, a) + dot(c, c) * cross(a, b);
  const double bound = doubled_area * norm(w);
  if (!(bound > 0)) return 0;
  const double ratio = 216 * volume * volume / bound;
  return volume < 0 ? -ratio : ratio;
}

TetQuality quality_of(const TetMesh& mesh) {
  TACTOR_DEMAND(!mesh.tets.empty());
  TetQuality quality;
  quality.smallest_angle = quality.worst_ratio = std::numeric_limits<double>::infinity();
  double edges = 0;
  for (const auto& tet : mesh.tets) {
    const TetCorners corners = corners_of(mesh, tet);
    quality.volume += volume_of(corners);
    quality.smallest_angle = std::min(quality.smallest_angle, dihedral_angles(corners).smallest);
    quality.worst_ratio = std::min(quality.worst_ratio, radius_ratio(corners));
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = i + 1; j < 4; ++j) edges += norm(corners[j] - corners[i]);
    }
  }
  quality.mean_edge = edges / (6 * static_cast<double>(mesh.tets.size()));
  return quality;
}

}  // namespace tactor
