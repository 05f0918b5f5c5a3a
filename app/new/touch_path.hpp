// Finds how a small ball can come to a mesh from outside, press it and slide along it.
#pragma once

#include <vector>

#include "nodes/physics/mesh/mesh.hpp"

namespace tactor {

/// Where the middle of the ball is as it lies on the surface, and the way out there.
struct TouchPoint {
  Vec3 p;       ///< m, in the frame of the mesh; a radius from the surface
  Vec3 normal;  ///< unit, out of the surface
};

/// The places of a slide in their order, about evenly spaced; one where there is nothing to slide along. The first can
/// be reached along its normal from outside the bounds without touching anything before, and the last be left so.
using TouchPath = std::vector<TouchPoint>;

/// A path of a ball of that radius (m) over `length` (m) at most, in `steps` steps. It prefers to come from above (+z).
/// `mesh`: of a solid, as load_solid returns it.
TouchPath find_touch_path(const TriangleMesh& mesh, double radius, double length, int steps);

}  // namespace tactor
