// What may be left out of a graph or coarsened in it, from the declarations of its nodes and from its scene.
#pragma once

#include <vector>

#include "app/lean/lean_search.hpp"
#include "framework/graph/spec.hpp"
#include "framework/node/registry.hpp"

namespace tactor {

/// The moves of a graph whose types are chosen (Plan::graph), but for its sinks: the coarser values of every parameter
/// that declares some, the cheaper types of every node (with the parameters that both have, and without the edges into
/// inputs that the new type lacks), of every moving body its rotation and its friction, and of a
/// deformable one fewer tetrahedra. Whether a graph can be run
/// so is not looked into.
std::vector<LeanMove<GraphSpec>> lean_moves(const GraphSpec& graph, Registry& registry);

}  // namespace tactor
