#include <algorithm>

#include "framework/graph/plan_steps.hpp"

namespace tactor {

namespace {

std::string why_needless(const NodeSpec& node, const Scene& scene) {
  if (node.info->unneeded) {
    if (std::string reason = node.info->unneeded(scene); !reason.empty()) return reason;
  }
  if (node.info->needs_torque && !scene.rotates()) {
    return scene.tool() == nullptr ? "no body of the scene moves" : "the scene is translation-only";
  }
  return {};
}

// Marks what is upstream of the kept nodes in `wanted`.
void mark_upstream(const std::vector<Wire>& wires, const Kept& kept, std::vector<bool>& wanted) {
  std::vector<std::vector<std::size_t>> writers(kept.nodes.size());
  for (std::size_t e = 0; e < wires.size(); ++e) {
    if (kept.edges[e]) writers[wires[e].to].push_back(wires[e].from);
  }
  std::vector<std::size_t> todo;
  for (std::size_t n = 0; n < wanted.size(); ++n) {
    if (wanted[n]) todo.push_back(n);
  }
  while (!todo.empty()) {
    const std::size_t reader = todo.back();
    todo.pop_back();
    for (const std::size_t writer : writers[reader]) {
      if (wanted[writer]) continue;
      wanted[writer] = true;
      todo.push_back(writer);
    }
  }
}

}  // namespace

std::vector<Wire> wires_of(const GraphSpec& graph) {
  std::map<std::string, std::size_t> index;
  for (std::size_t n = 0; n < graph.nodes.size(); ++n) index[graph.nodes[n].name] = n;
  std::vector<Wire> wires;
  for (const EdgeSpec& edge : graph.edges) {
    Wire wire{index.at(edge.from_node), 0, index.at(edge.to_node), 0};
    const NodeInfo& from = *graph.nodes[wire.from].info;
    const NodeInfo& to = *graph.nodes[wire.to].info;
    const OutputInfo* output = from.output(edge.from_port);
    const InputInfo* input = to.input(edge.to_port);
    TACTOR_DEMAND(output != nullptr && input != nullptr);
    wire.output = static_cast<std::size_t>(output - from.outputs.data());
    wire.input = static_cast<std::size_t>(input - to.inputs.data());
    wires.push_back(wire);
  }
  return wires;
}

bool is_an_end(const GraphSpec& graph, const NodeSpec& node) {
  return node.info->sink || node.info->sets || (graph.duration == until_stopped && node.info->actuator);
}

Kept prune(const GraphSpec& graph, const std::vector<Wire>& wires) {
  Kept kept;
  kept.nodes.assign(graph.nodes.size(), true);
  kept.edges.assign(graph.edges.size(), true);
  std::vector<std::string> edge_reasons(graph.edges.size());
  for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
    std::string reason = why_needless(graph.nodes[n], graph.scene);
    if (reason.empty()) continue;
    kept.nodes[n] = false;
    kept.node_reasons[n] = std::move(reason);
  }
  for (std::size_t e = 0; e < wires.size(); ++e) {
    const NodeSpec& reader = graph.nodes[wires[e].to];
    const InputInfo& input = reader.info->inputs[wires[e].input];
    if (input.ignored) edge_reasons[e] = input.ignored(reader.params);
    if (edge_reasons[e].empty() && input.unneeded) edge_reasons[e] = input.unneeded(graph.scene);
    if (!edge_reasons[e].empty() || !kept.nodes[wires[e].from] || !kept.nodes[wires[e].to]) kept.edges[e] = false;
  }

  std::vector<bool> wanted(graph.nodes.size(), false);
  for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
    const std::string prefix = graph.nodes[n].name + ".";
    const bool recorded = std::any_of(graph.record.begin(), graph.record.end(),
                                      [&](const std::string& stream) { return stream.starts_with(prefix); });
    wanted[n] = kept.nodes[n] && (is_an_end(graph, graph.nodes[n]) || recorded);
  }
  mark_upstream(wires, kept, wanted);
  for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
    if (!kept.nodes[n] || wanted[n]) continue;
    kept.nodes[n] = false;
    kept.node_reasons[n] = "its outputs reach no sink and no recording";
  }

  if (!graph.scene.rotates()) {
    kept.left_out.push_back(
        {"torque", graph.scene.tool() == nullptr ? "no body of the scene moves" : "the scene is translation-only",
         LeftOut::Kind::torque});
  }
  for (const auto& [n, reason] : kept.node_reasons) {
    // Its work is done by another node then.
    const bool costs = graph.nodes[n].cost.kind != CostModel::Kind::none && !graph.scene.deformable().empty();
    kept.left_out.push_back(
        {"node " + graph.nodes[n].name,
         reason + (costs ? "; its declared cost is left out too: give a cost to the node that does its work" : ""),
         LeftOut::Kind::node, graph.nodes[n].name});
  }
  for (std::size_t e = 0; e < wires.size(); ++e) {
    const bool from = kept.nodes[wires[e].from];
    const bool to = kept.nodes[wires[e].to];
    if (!from || !to) kept.edges[e] = false;
    if (kept.edges[e]) continue;
    const EdgeSpec& edge = graph.edges[e];
    std::string reason = edge_reasons[e];
    if (reason.empty()) reason = (from ? edge.to_node : edge.from_node) + " is left out";
    kept.left_out.push_back({"edge " + edge.name(), std::move(reason), LeftOut::Kind::edge});
  }
  return kept;
}

std::vector<bool> resolve_triggers(const GraphSpec& graph, const std::vector<Wire>& wires, const Kept& kept) {
  std::vector<bool> has_yes(graph.nodes.size(), false);
  const auto trigger = [&](const Wire& wire) { return graph.nodes[wire.to].info->inputs[wire.input].trigger; };
  for (std::size_t e = 0; e < wires.size(); ++e) {
    if (kept.edges[e] && trigger(wires[e]) == Trigger::yes) has_yes[wires[e].to] = true;
  }
  std::vector<bool> triggers(wires.size(), false);
  for (std::size_t e = 0; e < wires.size(); ++e) {
    const Trigger kind = trigger(wires[e]);
    triggers[e] = kept.edges[e] && (kind == Trigger::yes || (kind == Trigger::when_alone && !has_yes[wires[e].to]));
  }
  return triggers;
}

}  // namespace tactor
