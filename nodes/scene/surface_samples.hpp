// Points that stand for the surface of a mesh in contact, each with its share of the area.
#pragma once

#include <vector>

#include "nodes/scene/mesh.hpp"

namespace tactor {

struct SurfaceSample {
  Vec3 p;           ///< m, in the frame of the mesh
  double area = 0;  ///< m^2
};

/// The vertices first, in their order, then the points that refine the mesh. Where an edge is longer than `spacing`
/// (m), faces are bisected at their longest edge until none is, so long thin faces get few points; with spacing 0
/// there are only the vertices. Each sub-triangle gives a third of its area to each corner, so that the areas sum to
/// the surface's.
/// Throws InputError beyond a million samples.
std::vector<SurfaceSample> sample_surface(const TriangleMesh& mesh, double spacing);

}  // namespace tactor
