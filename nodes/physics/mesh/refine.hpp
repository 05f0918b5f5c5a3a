// A finer mesh of the same surface.
#pragma once

#include <vector>

#include "nodes/physics/mesh/mesh.hpp"

namespace tactor {

struct RefinedMesh {
  TriangleMesh mesh;             ///< the vertices of the mesh it was made of first, in their order
  std::vector<int> parent_face;  ///< of each face, the one of that mesh that it is part of
};

/// Bisects faces at their longest edge until no edge is longer than `longest_edge` (m, > 0). An edge is bisected for
/// both of its faces, so that a closed mesh stays closed. No point of a face is farther than longest_edge / sqrt(3)
/// from one of its corners.
/// Throws InputError beyond four million vertices.
RefinedMesh refine(const TriangleMesh& mesh, double longest_edge);

}  // namespace tactor
