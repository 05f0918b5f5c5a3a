// The parts of a graph file, each read from its tree into the spec.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "framework/graph/spec.hpp"
#include "framework/yaml/file_finder.hpp"
#include "framework/yaml/yaml_tree.hpp"

namespace tactor {

/// `scene`: gravity and bodies.
Scene read_scene(const Tree& tree, const FileFinder& files, Diagnostics& diagnostics);

/// The type that a node says by `type` or `python`; null, with an error, where it says none that is known.
const NodeInfo* read_type(const TreeEntry& node, const std::string& path, Registry& registry, const FileFinder& files,
                          Diagnostics& diagnostics);

/// `cost` of a node.
CostModel read_cost(const Tree& tree, const std::string& path, const FileFinder& files, Diagnostics& diagnostics);

/// `lane`, `thread`, `policy`, `priority` and `cpu` of the nodes, into their scheduling; `tree` is the map of nodes.
/// Nodes that share a thread have the same settings afterwards.
void read_lanes(std::vector<NodeSpec>& nodes, const Tree& tree, Registry& registry, Diagnostics& diagnostics);

/// The rate of the haptic loop, into the graph and its nodes: what `rate` of the graph and `rate` of those nodes say,
/// which must agree. `tree` is that of the graph.
void read_haptic_rate(GraphSpec& graph, const Tree& tree, Diagnostics& diagnostics);

/// Into parameters that are as in another node (ParamInfo::as_in) and that `tree`, that of the graph, does not give:
/// the value of the first node of that role that has a parameter of the name, kind and unit. An error where the bounds
/// or the choices here do not allow that value.
void read_shared_parameters(GraphSpec& graph, const Tree& tree, const FileFinder& files, Diagnostics& diagnostics);

/// Into the scene of a graph in which no body moves: the tool of the node that brings a scene itself
/// (NodeInfo::own_tool), with its gravity unless the graph gives one. Throws YamlError where the node cannot tell it,
/// and where a body of the scene has its name.
void take_own_tool(GraphSpec& graph);

/// No edge of the realtime lane may wait where the clock is real.
void check_realtime_edges(const GraphSpec& graph, Diagnostics& diagnostics);

/// `live`.
LiveSettings read_live(const Tree& tree, const FileFinder& files, Diagnostics& diagnostics);

/// `edges`; ends at nodes of `broken` (whose own errors are told already) are not looked at further.
std::vector<EdgeSpec> read_edges(const Tree& tree, const std::vector<NodeSpec>& nodes,
                                 const std::set<std::string>& broken, Diagnostics& diagnostics);

/// `record`.
std::vector<std::string> read_record(const Tree& tree, const std::vector<NodeSpec>& nodes,
                                     const std::set<std::string>& broken, Diagnostics& diagnostics);

}  // namespace tactor
