// Nodes that are spread over deforming surfaces, for what moves the bodies as a whole.
#pragma once

#include <vector>

#include "nodes/physics/deformable/soft_scene.hpp"

namespace tactor {

/// Of each body up to `count` free nodes of its surface: each is, at rest, the farthest from those before it and from
/// the fixed nodes of the surface. The first of a body that nothing holds is its lowest node. Of several as far, the
/// lowest. A node that is nowhere apart from another one is left out.
std::vector<std::vector<int>> spread_nodes(const SoftScene& soft, int count);

}  // namespace tactor
