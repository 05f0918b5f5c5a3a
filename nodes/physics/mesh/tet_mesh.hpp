// Meshes of tetrahedra.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "framework/core/spatial.hpp"

namespace tactor {

/// Faces of a volume mesh that its file gives a name.
struct FaceGroup {
  std::string name;
  std::vector<std::array<int, 3>> faces;
};

/// A mesh of tetrahedra that share their corners.
struct TetMesh {
  std::vector<Vec3> nodes;                ///< m, in the frame of the body
  std::vector<std::array<int, 4>> tets;   ///< of positive volume: dot(b - a, cross(c - a, d - a)) > 0
  std::vector<std::array<int, 3>> faces;  ///< the boundary, counter-clockwise as seen from outside
  std::vector<FaceGroup> groups;
};

}  // namespace tactor
