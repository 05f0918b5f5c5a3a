// A shortest use of a node type in a graph, made from its declaration.
#pragma once

#include <string>
#include <vector>

#include "framework/node/info.hpp"

namespace tactor {

/// YAML with the node, the parameters that it requires, and an edge into each input that it requires, from a node type
/// of `types` that sends such messages.
std::string example_of(const NodeInfo& info, const std::vector<const NodeInfo*>& types);

}  // namespace tactor
