// How well shaped tetrahedra are.
#pragma once

#include <array>
#include <cstddef>

#include "nodes/physics/mesh/tet_mesh.hpp"

namespace tactor {

/// The corners of a tetrahedron, m.
using TetCorners = std::array<Vec3, 4>;

inline TetCorners corners_of(const TetMesh& mesh, const std::array<int, 4>& tet) {
  const auto node = [&](std::size_t i) { return mesh.nodes[static_cast<std::size_t>(tet[i])]; };
  return {node(0), node(1), node(2), node(3)};
}

/// dot(b - a, cross(c - a, d - a)) / 6, m^3; negative where the tetrahedron is inverted.
double volume_of(const TetCorners& tet);

/// The smallest and the largest of the six angles between its faces, inside, in rad: 0 and pi where it is flat,
/// arccos(1/3) = 70.53 degrees both where it is regular.
struct DihedralAngles {
  double smallest = 0, largest = 0;
};
DihedralAngles dihedral_angles(const TetCorners& tet);

/// 3 times the radius of the inscribed ball over that of the circumscribed one: 1 for a regular tetrahedron, 0 for a
/// flat one. An inverted one has a negative ratio.
double radius_ratio(const TetCorners& tet);

/// Of all tetrahedra of a mesh that has one or more.
struct TetQuality {
  double volume = 0;          ///< m^3, the sum
  double smallest_angle = 0;  ///< rad, the smallest dihedral angle
  double worst_ratio = 0;     ///< the smallest radius ratio
  double mean_edge = 0;       ///< m, each edge counted once for each of its tetrahedra
};
TetQuality quality_of(const TetMesh& mesh);

}  // namespace tactor
