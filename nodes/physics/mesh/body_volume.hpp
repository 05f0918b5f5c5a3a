// The tetrahedra of a scene's deformable body, with their stiffness and the nodes that are held.
#pragma once

#include <vector>

#include "framework/core/scene.hpp"
#include "nodes/physics/mesh/body_mesh.hpp"
#include "nodes/physics/mesh/tet_mesh.hpp"

namespace tactor {

struct BodyVolume {
  TetMesh mesh;               ///< m, in the frame of the body, which is that of its file
  std::vector<double> young;  ///< Pa, of each tetrahedron
  std::vector<char> fixed;    ///< of each node: 1 where it does not move
};

/// The mesh of a body of Motion::deformable:
/// - of a surface (OFF, OBJ, STL, PLY): filled by filled_surface.hpp, its scale applied;
/// - of a file of tetrahedra (MSH, VTU): volume_formats.hpp, its scale applied, its nodes in their order;
/// - of a box: box_volume.hpp.
/// A tetrahedron has the stiffness of the last inclusion whose ball holds its centroid, else that of the body. A node
/// is fixed where one of the regions holds it, which reach a millionth of the body's length farther than they say, so
/// that nodes on their planes belong to them. The same body gives the same mesh, node by node. Adds the numbers of
/// tetrahedra and nodes and their quality to `notes`, each once, beginning with the name of the body, where it is not
/// null. Throws ValueError, with the path of the value that is to be changed, where the shape has no volume mesh, the
/// file cannot be used, there would be more than 200,000 tetrahedra, or a region or inclusion holds nothing.
BodyVolume load_body_volume(const Body& body, Notes* notes = nullptr);

/// The surface of a body that is to be drawn: of a deformable one the boundary of its tetrahedra, whose vertices are
/// surface_nodes (tet_topology.hpp) in that order; else its mesh, as load_body_mesh has it. Throws as both do.
TriangleMesh load_body_surface(const Body& body, Notes* notes = nullptr);

}  // namespace tactor
