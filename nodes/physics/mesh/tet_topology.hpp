// How tetrahedra hang together: their boundary, the nodes on it, and the order of nodes.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "nodes/physics/mesh/mesh.hpp"
#include "nodes/physics/mesh/tet_mesh.hpp"

namespace tactor {

/// The face opposite to corner `k` of a tetrahedron of positive volume, counter-clockwise as seen from outside.
constexpr std::array<int, 3> face_opposite(const std::array<int, 4>& tet, std::size_t k) {
  constexpr std::array<std::array<std::size_t, 3>, 4> faces{{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};
  return {tet[faces[k][0]], tet[faces[k][1]], tet[faces[k][2]]};
}

/// What is wrong with how tetrahedra of positive volume meet: `tetrahedra 3 and 8 overlap: ...`, or nothing.
std::string find_overlap(const TetMesh& mesh);

/// The faces of one tetrahedron only, in the order of the tetrahedra, counter-clockwise as seen from outside.
std::vector<std::array<int, 3>> boundary_faces(const std::vector<std::array<int, 4>>& tets);

/// Sets `faces` to the boundary, takes out nodes that no tetrahedron has and faces of groups that name them, and turns
/// faces of groups that are of the boundary as the boundary has them. Groups without a face are gone.
void finish_mesh(TetMesh& mesh);

/// Puts nodes into the order of a curve that fills space (Morton's), so that neighbours lie near each other in memory,
/// and tetrahedra into that of their lowest node. `mesh` has neither faces nor groups yet.
void order_by_place(TetMesh& mesh);

/// How many pieces hang together by nodes.
std::size_t pieces_of(const TetMesh& mesh);

/// The nodes that faces of the boundary use, in ascending order.
std::vector<int> surface_nodes(const TetMesh& mesh);

/// The boundary as triangles: its vertices are surface_nodes in that order, its faces those of the mesh in their order.
TriangleMesh surface_of(const TetMesh& mesh);

}  // namespace tactor
