// The steps from a checked graph to a plan.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "framework/graph/plan.hpp"

namespace tactor {

/// The edges of a graph by the indices of their nodes and ports.
struct Wire {
  std::size_t from = 0, output = 0, to = 0, input = 0;
};
std::vector<Wire> wires_of(const GraphSpec& graph);

/// Gives the nodes whose types stand for others the types that suit the scene.
std::vector<Chosen> choose_types(GraphSpec& graph);

/// What stays of a graph, by index.
struct Kept {
  std::vector<bool> nodes;
  std::vector<bool> edges;
  std::map<std::size_t, std::string> node_reasons;  ///< why a node is left out
  std::vector<LeftOut> left_out;
};

/// True if a graph may run for that node alone: it is a sink, or sets parameters. So is a device in a run until
/// stopped, which records nothing.
bool is_an_end(const GraphSpec& graph, const NodeSpec& node);

/// Takes out what the scene and the parameters make needless, and then what reaches no such end and no recording.
Kept prune(const GraphSpec& graph, const std::vector<Wire>& wires);

/// Refuses what a node says it may set and cannot: that is no tunable parameter of a kept node, or not its value. Also
/// refuses a setter that does not wait for the ramp of what it sets, and one that takes a device's dead-man button for
/// an answer.
void check_settings(const GraphSpec& graph, const Kept& kept, const NodeSpec& setter, Diagnostics& diagnostics);

/// For each edge whether it makes its reader step.
std::vector<bool> resolve_triggers(const GraphSpec& graph, const std::vector<Wire>& wires, const Kept& kept);

/// A cycle of triggers without a delay, as indices of edges; empty where there is none.
std::vector<std::size_t> find_trigger_cycle(const GraphSpec& graph, const std::vector<Wire>& wires, const Kept& kept,
                                            const std::vector<bool>& triggers);

/// The kept nodes, writers before readers. Edges that trigger without a delay count first, then the others in the order
/// of the file; one that would close a loop is the loop's way back and does not count. What is free is in that order
/// too.
std::vector<std::size_t> order_nodes(const GraphSpec& graph, const std::vector<Wire>& wires, const Kept& kept,
                                     const std::vector<bool>& triggers);

}  // namespace tactor
