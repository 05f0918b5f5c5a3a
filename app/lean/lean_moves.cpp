#include "app/lean/lean_moves.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "framework/graph/plan.hpp"

namespace tactor {

namespace {

using Moves = std::vector<LeanMove<GraphSpec>>;

/// With fewer of them a shape is no longer the body's.
constexpr int fewest_tetrahedra = 200;

std::string text_of(const ParamInfo& info, const ParamValue& value) {
  if (const auto* b = std::get_if<bool>(&value)) return *b ? "true" : "false";
  if (const auto* i = std::get_if<std::int64_t>(&value)) return std::to_string(*i);
  if (const auto* x = std::get_if<double>(&value)) {
    if (info.unit == "m" && *x != 0) return fmt::format("{:g} mm", 1e3 * *x);
    if (info.unit == "s" && *x != 0) return fmt::format("{:g} ms", 1e3 * *x);
    return info.unit == "1" || *x == 0 ? fmt::format("{:g}", *x) : fmt::format("{:g} {}", *x, info.unit);
  }
  if (const auto* text = std::get_if<std::string>(&value)) return *text;
  return "...";
}

/// The outputs of a node that something reads or records.
std::vector<std::string_view> read_outputs(const Plan& plan, std::size_t n) {
  std::vector<std::string_view> names;
  const auto& outputs = plan.nodes[n].info->outputs;
  for (const PlannedEdge& edge : plan.edges) {
    if (edge.from == n) names.push_back(outputs[edge.output].name);
  }
  for (const PlannedStream& stream : plan.streams) {
    if (stream.node == n) names.push_back(outputs[stream.output].name);
  }
  return names;
}

/// Only of parameters that the node reads in this graph: of others nothing can be saved.
void add_coarser(const GraphSpec& graph, std::size_t n, const ParamUse& use, Moves& moves) {
  const NodeSpec& node = graph.nodes[n];
  for (std::size_t i = 0; i < node.params.size(); ++i) {
    const ParamInfo& info = node.info->params[i];
    if (info.unread && !info.unread(node.params, use).empty()) continue;
    const std::string name = node.name + "." + info.name;
    ParamValue value = node.params[i];
    while (const auto next = next_coarser(info, value)) {
      value = *next;
      LeanMove<GraphSpec> move{.group = name,
                               .what = name + ": " + text_of(info, node.params[i]) + " -> " + text_of(info, value),
                               .state = graph};
      move.state.nodes[n].params[i] = value;
      moves.push_back(std::move(move));
    }
  }
}

/// The node as one of another type: parameters pass on by name, the others take their defaults, and the rate of the
/// haptic loop is the graph's. False where the new type has a parameter that must be given.
bool retype(NodeSpec& node, const NodeInfo& info, double haptic_rate) {
  std::vector<ParamValue> params;
  for (const ParamInfo& param : info.params) {
    const auto given = node.info->param(param.name);
    const bool passes = given && node.info->params[*given].kind == param.kind;
    // A default that only the old type has is none of the user's.
    const bool is_default = passes && node.info->params[*given].default_value == node.params[*given];
    if (passes && !(is_default && param.default_value)) {
      params.push_back(node.params[*given]);
    } else if (param.default_value) {
      params.push_back(*param.default_value);
    } else {
      return false;
    }
  }
  if (info.haptic_rate) params[*info.rate_parameter] = haptic_rate;
  node.info = &info;
  node.params = std::move(params);
  return true;
}

bool sends(const NodeInfo& info, const std::string& port, const MessageType* type) {
  const OutputInfo* output = info.output(port);
  return output != nullptr && output->type == type;
}

bool takes(const NodeInfo& info, const std::string& port, const MessageType* type) {
  const InputInfo* input = info.input(port);
  return input != nullptr && input->type == type;
}

/// Leaves out what the node's new type has no port for. False where that would be an output that is used.
bool reconnect(GraphSpec& graph, const NodeInfo& before, const NodeSpec& node) {
  for (const EdgeSpec& edge : graph.edges) {
    if (edge.from_node == node.name && !sends(*node.info, edge.from_port, before.output(edge.from_port)->type)) {
      return false;
    }
  }
  for (const std::string& stream : graph.record) {
    const std::string port = stream.substr(stream.find('.') + 1);
    if (stream.starts_with(node.name + ".") && node.info->output(port) == nullptr) return false;
  }
  std::erase_if(graph.edges, [&](const EdgeSpec& edge) {
    return edge.to_node == node.name && !takes(*node.info, edge.to_port, before.input(edge.to_port)->type);
  });
  return true;
}

void add_cheaper_types(const GraphSpec& graph, std::size_t n, Registry& registry, Moves& moves) {
  const NodeInfo& before = *graph.nodes[n].info;
  for (const std::string& type : before.cheaper_types) {
    const NodeInfo* info = registry.find(type);
    if (info == nullptr) continue;
    const std::string what = graph.nodes[n].name + ": " + before.type + " -> " + type;
    LeanMove<GraphSpec> move{.group = what, .what = what, .state = graph};
    if (retype(move.state.nodes[n], *info, graph.rate) && reconnect(move.state, before, move.state.nodes[n])) {
      moves.push_back(std::move(move));
    }
  }
}

/// Fewer tetrahedra, a half each time; not of a body whose `cell_size` counts.
void add_fewer_tetrahedra(const GraphSpec& graph, Moves& moves) {
  for (const std::size_t i : graph.scene.deformable()) {
    const Body& body = graph.scene.bodies[i];
    if (body.deformable.cell_size > 0) continue;
    const std::string name = "tetrahedra of " + body.name;
    for (int fewer = body.deformable.tetrahedra / 2; fewer >= fewest_tetrahedra; fewer /= 2) {
      LeanMove<GraphSpec> move{
          .group = name, .what = fmt::format("{}: {} -> {}", name, body.deformable.tetrahedra, fewer), .state = graph};
      move.state.scene.bodies[i].deformable.tetrahedra = fewer;
      moves.push_back(std::move(move));
    }
  }
}

void add_scene(const GraphSpec& graph, Moves& moves) {
  add_fewer_tetrahedra(graph, moves);
  for (const std::size_t i : graph.scene.moving()) {
    const Body& body = graph.scene.bodies[i];
    if (body.motion == Motion::rigid) {
      const bool is_tool = i == graph.scene.moving().front();
      const std::string what = (is_tool ? "without rotation and torque of " : "without rotation of ") + body.name;
      LeanMove<GraphSpec> move{.group = what, .what = what, .leaves_out = true, .state = graph};
      move.state.scene.bodies[i].motion = Motion::translation;
      moves.push_back(std::move(move));
    }
    if (body.material.friction > 0) {
      const std::string what = "without friction of " + body.name;
      LeanMove<GraphSpec> move{.group = what, .what = what, .leaves_out = true, .state = graph};
      move.state.scene.bodies[i].material.friction = 0;
      moves.push_back(std::move(move));
    }
  }
}

}  // namespace

std::vector<LeanMove<GraphSpec>> lean_moves(const GraphSpec& graph, Registry& registry) {
  Moves moves;
  add_scene(graph, moves);
  // What is left out costs nothing, and nobody reads its parameters.
  const Plan plan = make_plan(graph);
  for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
    if (graph.nodes[n].info->sink) continue;
    const auto planned = std::find_if(plan.nodes.begin(), plan.nodes.end(),
                                      [&](const NodeSpec& node) { return node.name == graph.nodes[n].name; });
    if (planned == plan.nodes.end()) continue;
    const auto p = static_cast<std::size_t>(planned - plan.nodes.begin());
    add_cheaper_types(graph, n, registry, moves);
    add_coarser(graph, n, {&graph.scene, read_outputs(plan, p)}, moves);
  }
  return moves;
}

}  // namespace tactor
