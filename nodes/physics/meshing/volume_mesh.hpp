// Fills a closed surface with tetrahedra, by CGAL's Mesh_3.
#pragma once

#include <string>

#include "nodes/physics/mesh/mesh.hpp"
#include "nodes/physics/mesh/tet_mesh.hpp"
#include "nodes/physics/mesh/volume_fineness.hpp"

namespace tactor {

/// Nodes and tetrahedra that fill `solid`, as load_solid returns it: a restricted Delaunay triangulation (Oudot, Rineau
/// and Yvinec, "Meshing volumes bounded by smooth surfaces", 2005), whose slivers are taken out by perturbation and
/// weights (Cheng et al., "Sliver exudation", 2000). Its boundary is a manifold whose nodes lie on the surface. Long
/// sharp edges of the surface are kept as edges; short ones, finer than the tetrahedra, are rounded. The bound of the
/// radii of circumscribed balls is found in a few tries, so that the count or the mean edge is within 10 % of what is
/// asked for where the shape allows it. The same input gives the same mesh: random numbers are drawn from a fixed seed,
/// and no step is ended by a clock. Throws InputError, beginning with `file`, where no tetrahedron comes about.
TetMesh volume_mesh(const TriangleMesh& solid, const VolumeFineness& fineness, const std::string& file);

}  // namespace tactor
