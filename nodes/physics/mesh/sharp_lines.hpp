// The long sharp edges of a surface, as lines.
#pragma once

#include <vector>

#include "nodes/physics/mesh/mesh.hpp"

namespace tactor {

/// Chains of vertices along edges in which the normals of the two faces differ by more than `angle` (rad). A chain ends
/// where not exactly two sharp edges meet, or where it turns by more than 45 degrees; one that closes begins and ends
/// in the same vertex. Edges that hang together and are shorter in all than `shortest` (m) are left out: such are
/// roughness of a scanned surface, not its shape. `mesh`: closed.
std::vector<std::vector<int>> sharp_lines(const TriangleMesh& mesh, double angle, double shortest);

/// About how many nodes a mesh has on the lines where their distance is `longest` (m) or half of that to the nearest
/// line without a common end, whichever is less: what a mesh of tetrahedra pays for keeping them.
double nodes_on_lines(const TriangleMesh& mesh, const std::vector<std::vector<int>>& lines, double longest);

}  // namespace tactor
