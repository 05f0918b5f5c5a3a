// What an elastic solid is made of.
#pragma once

#include <cstddef>
#include <vector>

#include "nodes/physics/mesh/tet_mesh.hpp"

namespace tactor {

/// An elastic solid, at rest where its mesh lies.
struct SoftBody {
  TetMesh mesh;               ///< m, in the world W
  std::vector<double> young;  ///< Pa, above zero, one a tetrahedron
  double poisson = 0.45;      ///< above -1, below 0.5
  double density = 1000;      ///< kg/m^3
  double damping = 0.005;     ///< s, Rayleigh's beta: the damping matrix has this times the stiffness
  double drag = 0;            ///< 1/s, Rayleigh's alpha: and this times the mass
  std::vector<char> fixed;    ///< 1 where a node does not move, one a node
};

/// Throws InputError, beginning with "deformable body NUMBER", where lists do not fit the mesh, a material parameter is
/// out of its bounds, or a tetrahedron is flat or inverted.
void check_soft_body(const SoftBody& body, std::size_t number);

enum class Elasticity {
  corotational,  ///< linear elasticity in a frame that turns with the material
  neo_hookean,   ///< for large strain
};

enum class ElementOrder {
  linear,  ///< 4 nodes: strain is uniform in a tetrahedron; too stiff in bending, above all where poisson is near 0.5
  quadratic,  ///< 10 nodes, one more in the middle of each edge: strain is linear
};

}  // namespace tactor
