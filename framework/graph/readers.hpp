// The parts of a graph file, each read from its tree into the spec.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "framework/graph/files.hpp"
#include "framework/graph/spec.hpp"
#include "framework/graph/yaml_tree.hpp"

namespace tactor {

/// `scene`: gravity and bodies.
Scene read_scene(const Tree& tree, const FileFinder& files, Diagnostics& diagnostics);

/// `cost` of a node.
CostModel read_cost(const Tree& tree, const std::string& path, const FileFinder& files, Diagnostics& diagnostics);

/// `edges`; ends at nodes of `broken` (whose own errors are told already) are not looked at further.
std::vector<EdgeSpec> read_edges(const Tree& tree, const std::vector<NodeSpec>& nodes,
                                 const std::set<std::string>& broken, Diagnostics& diagnostics);

/// `record`.
std::vector<std::string> read_record(const Tree& tree, const std::vector<NodeSpec>& nodes,
                                     const std::set<std::string>& broken, Diagnostics& diagnostics);

}  // namespace tactor
