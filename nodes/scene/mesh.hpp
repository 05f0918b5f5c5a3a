// Triangle meshes and the reader of OFF files.
#pragma once

#include <array>
#include <filesystem>
#include <vector>

#include "framework/core/spatial.hpp"

namespace tactor {

/// A triangle mesh. Faces list vertex indices counter-clockwise as seen from outside.
struct TriangleMesh {
  std::vector<Vec3> vertices;  ///< m, in the frame of the body
  std::vector<std::array<int, 3>> faces;
};

/// Reads an ASCII OFF file. A face of more than three corners is cut into a fan, which suits convex faces only.
/// Throws InputError with file:line and the mend where the file is not a mesh: missing header, wrong counts, a number
/// that is not finite, an index out of range, a face of fewer than three or of repeated corners, text after the end.
TriangleMesh read_off(const std::filesystem::path& path);

/// Twice the area of a face times its outward unit normal, m^2.
Vec3 doubled_area_normal(const TriangleMesh& mesh, const std::array<int, 3>& face);

/// The area of the surface, m^2.
double surface_area(const TriangleMesh& mesh);

}  // namespace tactor
