// Triangle meshes.
#pragma once

#include <array>
#include <vector>

#include "framework/core/spatial.hpp"

namespace tactor {

/// A triangle mesh. Faces list vertex indices counter-clockwise as seen from outside.
struct TriangleMesh {
  std::vector<Vec3> vertices;  ///< m, in the frame of the body
  std::vector<std::array<int, 3>> faces;
};

/// Twice the area of a face times its outward unit normal, m^2.
Vec3 doubled_area_normal(const TriangleMesh& mesh, const std::array<int, 3>& face);

/// The area of the surface, m^2.
double surface_area(const TriangleMesh& mesh);

}  // namespace tactor
