// A Plan: the nodes and edges of a graph that its scene needs, in the order an engine steps them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "framework/graph/spec.hpp"
#include "framework/graph/text_table.hpp"

namespace tactor {

/// Something that was not needed and why.
struct LeftOut {
  enum class Kind : std::uint8_t { other, torque, node, edge, recording };
  std::string what;  ///< `node refit`, `torque`, `edge a.x -> b.y`
  std::string why;   ///< for example `the coefficients are fixed`
  Kind kind = Kind::other;
  std::string node{};  ///< its name, where it is a node
};

/// A node whose type stood for others, and what it became in this scene.
struct Chosen {
  std::string node;
  std::string asked;  ///< the type in the file
  std::string type;   ///< the type that is planned
  std::string why;
};

/// An edge between planned nodes.
struct PlannedEdge {
  EdgeSpec spec;
  std::size_t from = 0;    ///< index into Plan::nodes
  std::size_t output = 0;  ///< index into the writer's NodeInfo::outputs
  std::size_t to = 0;
  std::size_t input = 0;
  bool triggers = false;  ///< a message on it makes the reader step
};

/// An output that is recorded.
struct PlannedStream {
  std::string name;  ///< `node.port`
  std::size_t node = 0;
  std::size_t output = 0;
};

/// What an engine runs.
struct Plan {
  GraphSpec graph;              ///< scene, clock, duration, seed; all nodes, left out or not, of the chosen types
  std::vector<NodeSpec> nodes;  ///< those that run, writers before readers; the order breaks ties in time
  std::vector<PlannedEdge> edges;
  std::vector<PlannedStream> streams;
  std::vector<Chosen> chosen;
  std::vector<LeftOut> left_out;
  bool torque = true;  ///< false: the scene is translation-only
};

/// Chooses the types that suit the scene, leaves out what it does not need and orders the rest. Throws GraphError for
/// cycles of triggers without a delay and for required inputs that nothing feeds.
Plan make_plan(GraphSpec graph);

/// Nodes with a rate step so often a second in a reference run, or more often.
inline constexpr double reference_rate = 10000;

/// The plan of the run that `tested` is compared with: only what feeds the `reference` inputs of its sinks, no costs,
/// no lanes, no recordings, and the parameters that declare a value for it (no encoder step). Nodes with a rate step at
/// `reference_rate`, or at their own where that is faster. None exceeds the bound of its parameter. One whose rate
/// declares another value steps at that one, or at its own; so 0 keeps it at its own, as data need that come at one
/// rate. Empty nodes where no sink asks for a reference.
Plan make_reference_plan(const Plan& tested);
/// The graph of that plan; no nodes where no sink asks for a reference.
GraphSpec reference_graph(const Plan& tested);
/// Plans such a graph, perhaps changed: in it sinks only listen, and no hardware is driven.
Plan plan_reference(GraphSpec graph);

/// The plan as a diagram.
enum class DiagramFormat : std::uint8_t { mermaid, dot };
std::string to_diagram(const Plan& plan, DiagramFormat format);

/// `tactor check --explain`: nodes, edges with their queues, what was left out and why, in so many columns.
std::string explain(const Plan& plan, std::size_t columns = usual_columns);

/// The JSON Schema (draft 2020-12) of graph files, from the declarations of all node types.
std::string graph_schema(Registry& registry);

}  // namespace tactor
