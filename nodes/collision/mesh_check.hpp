// Refuses meshes that have no inside.
#pragma once

#include <string>

#include "nodes/scene/mesh.hpp"

namespace tactor {

/// Throws InputError, beginning with `name` (a file), where the mesh is not a closed manifold surface with faces
/// counter-clockwise as seen from outside, or where it cuts itself. The message says the fault and the mend.
void check_solid(const TriangleMesh& mesh, const std::string& name);

}  // namespace tactor
