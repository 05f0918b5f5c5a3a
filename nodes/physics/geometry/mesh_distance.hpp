// The ways to measure the distance of a mesh that contacts choose from.
#pragma once

#include <functional>
#include <memory>

#include "nodes/physics/geometry/cell_distance.hpp"
#include "nodes/physics/mesh/body_mesh.hpp"

namespace tactor {

/// Makes the distance of a mesh, which contacts ask for up to `reach` (m) from its surface.
using MakeMeshDistance = std::function<std::shared_ptr<const SignedDistance>(const TriangleMesh& mesh, double reach)>;

/// CellDistance with lists as far as `reach`, but no farther than an eighth of the mesh's length, beyond which most of
/// its box would have them; its tree answers there. Made once and kept in the cache;
/// all who ask for the same cells in a process share them; `notes` as for load_body_mesh.
MakeMeshDistance cell_distances(const CellOptions& options, Notes* notes);

/// TreeDistance: nothing to prepare, and slower to ask.
MakeMeshDistance tree_distances();

/// ExactDistance of the plugin `tactor_cgal`. What is returned throws InputError where the plugin is not installed.
MakeMeshDistance exact_distances();

}  // namespace tactor
