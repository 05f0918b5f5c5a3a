// Volume, centre of mass and inertia of a closed mesh of uniform density.
#pragma once

#include <Eigen/Core>

#include "nodes/physics/mesh/mesh.hpp"

namespace tactor {

/// Of a body of density 1 kg/m^3, in the frame of its mesh.
struct MassProperties {
  double volume = 0;  ///< m^3, positive where faces are counter-clockwise from outside
  Vec3 center;        ///< m, centre of mass
  Eigen::Matrix3d
      inertia;  ///< kg m^2 about the centre of mass: integral of (|r|^2 1 - r r^T) dV, that is m^5 * 1 kg/m^3
};

/// The exact integrals over the polyhedron: each face with a reference point makes a signed tetrahedron, whose second
/// moments are closed forms of its corners (Tonon, "Explicit exact formulas for the 3-D tetrahedron inertia tensor in
/// terms of its vertex coordinates", J. Math. Stat. 1(1), 2005). A mesh of no volume gives volume 0 and zeros.
MassProperties mass_properties(const TriangleMesh& mesh);

}  // namespace tactor
