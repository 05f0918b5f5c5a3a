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

/// A cantilever ten times as long as high, of cubes of six tetrahedra each, bends by this share of what beam theory
/// says:
///   |                                | 2 cubes high | 4    | 8    |
///   | linear, Poisson's ratio 0      | 0.55         | 0.82 | 0.95 |
///   | linear, Poisson's ratio 0.45   | 0.30         | 0.59 | 0.83 |
///   | quadratic, 0 and 0.45          | 1.00 and 0.96 (its clamped end is stiffer than the theory's) |
enum class ElementOrder {
  linear,     ///< 4 nodes: strain is uniform in a tetrahedron. Too stiff in bending, above all where Poisson's ratio is
              ///< near 0.5
  quadratic,  ///< 10 nodes, one more in the middle of each edge: strain is linear. Assembly takes eight times as long
};

}  // namespace tactor
