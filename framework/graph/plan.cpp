#include "framework/graph/plan.hpp"

#include <algorithm>
#include <set>

#include "framework/graph/plan_steps.hpp"

namespace tactor {

namespace {

// A sink that judges, in the run it judges against: it only takes in there.
bool only_listens(const NodeInfo& info) {
  return info.sink && std::any_of(info.inputs.begin(), info.inputs.end(), [](const auto& i) { return i.reference; });
}

std::string outputs_of_type(const GraphSpec& graph, std::string_view type) {
  std::string text;
  for (const NodeSpec& node : graph.nodes) {
    for (const OutputInfo& output : node.info->outputs) {
      if (output.type->name == type) text += (text.empty() ? "" : ", ") + node.name + "." + output.name;
    }
  }
  return text.empty() ? "no node of the graph has one" : "outputs of that type: " + text;
}

void check_required(const GraphSpec& graph, const std::vector<Wire>& wires, const Kept& kept, std::size_t n,
                    Diagnostics& diagnostics) {
  const NodeSpec& node = graph.nodes[n];
  for (std::size_t i = 0; i < node.info->inputs.size(); ++i) {
    const InputInfo& input = node.info->inputs[i];
    const std::string needed = !input.required && input.needed ? input.needed(graph.scene) : std::string();
    if (!input.required && needed.empty()) continue;
    if (input.ignored && !input.ignored(node.params).empty()) continue;
    const std::string because = needed.empty() ? std::string() : ", because " + needed;
    const auto feeds = [&](const Wire& wire) { return wire.to == n && wire.input == i; };
    const auto wire = std::find_if(wires.begin(), wires.end(), feeds);
    const std::string name = node.name + "." + input.name + " (" + std::string(input.type->name) + ")" + because;
    if (wire == wires.end()) {
      diagnostics.error(node.place, "nodes." + node.name + ": expected an edge into " + name + ", found none; " +
                                        outputs_of_type(graph, input.type->name));
    } else if (!kept.nodes[wire->from]) {
      diagnostics.error(node.place, "nodes." + node.name + ": " + name + " is required, and " +
                                        graph.nodes[wire->from].name +
                                        ", which feeds it, is left out: " + kept.node_reasons.at(wire->from));
    }
  }
}

void check_refused(const GraphSpec& graph, const std::vector<Wire>& wires, const Kept& kept, Diagnostics& diagnostics) {
  for (std::size_t e = 0; e < wires.size(); ++e) {
    if (!kept.edges[e]) continue;
    const NodeSpec &from = graph.nodes[wires[e].from], &to = graph.nodes[wires[e].to];
    const OutputInfo& output = from.info->outputs[wires[e].output];
    const InputInfo& input = to.info->inputs[wires[e].input];
    if (output.kind.empty() || output.kind != input.refused_kind) continue;
    diagnostics.error(graph.edges[e].place, "edge " + graph.edges[e].name() + ": " + to.name + " (" + to.info->type +
                                                ") does not take the " + output.kind + " " + output.name + " of " +
                                                from.name + " (" + from.info->type + "): " + input.refused_why);
  }
}

/// Refuses physics of another law where a node steps the scene itself.
void check_scene_law(const GraphSpec& graph, const std::vector<Wire>& wires, const Kept& kept,
                     Diagnostics& diagnostics) {
  for (std::size_t e = 0; e < wires.size(); ++e) {
    if (!kept.edges[e]) continue;
    const NodeSpec &from = graph.nodes[wires[e].from], &to = graph.nodes[wires[e].to];
    const InputInfo& input = to.info->inputs[wires[e].input];
    if (input.scene_law_why.empty() || !from.info->is_foreign_physics()) continue;
    diagnostics.error(graph.edges[e].place, "edge " + graph.edges[e].name() + ": " + input.scene_law_why + "; " +
                                                from.name + " (" + from.info->type + ") is physics of another kind");
  }
}

void check_steps(const GraphSpec& graph, const std::vector<Wire>& wires, const std::vector<bool>& triggers,
                 std::size_t n, Diagnostics& diagnostics) {
  const NodeSpec& node = graph.nodes[n];
  if (node.info->rate_parameter || node.info->fed) return;
  for (std::size_t e = 0; e < wires.size(); ++e) {
    if (triggers[e] && wires[e].to == n) return;
  }
  std::string inputs;
  for (const InputInfo& input : node.info->inputs) {
    if (input.trigger != Trigger::no) inputs += (inputs.empty() ? "" : ", ") + input.name;
  }
  diagnostics.error(node.place, "nodes." + node.name +
                                    ": nothing makes it step: expected an edge into one of its triggers (" +
                                    (inputs.empty() ? "it has none" : inputs) + "), found none that is left");
}

void check_hardware(const GraphSpec& graph, const NodeSpec& node, bool reference, Diagnostics& diagnostics) {
  // A reference run drives no hardware: there a device goes along the path of the run under test.
  if (reference || !node.info->hardware || graph.clock == Clock::real) return;
  diagnostics.error(node.place, "nodes." + node.name + ": expected clock: real, because " + node.info->type +
                                    " drives hardware; found clock: virtual");
}

void check_cycle(const GraphSpec& graph, const std::vector<Wire>& wires, const Kept& kept,
                 const std::vector<bool>& triggers, Diagnostics& diagnostics) {
  const std::vector<std::size_t> cycle = find_trigger_cycle(graph, wires, kept, triggers);
  if (cycle.empty()) return;
  std::string text;
  for (const std::size_t e : cycle) text += (text.empty() ? "" : ", ") + graph.edges[e].name();
  diagnostics.error(graph.edges[cycle[0]].place,
                    "these edges trigger each other without end: " + text + "; give one of them a delay");
}

/// The rate in a reference run of a node that steps at `own` in the run under test.
double rate_in_reference(const NodeInfo& info, double own) {
  const ParamInfo& rate = info.params[*info.rate_parameter];
  const double least = rate.in_reference ? std::get<double>(*rate.in_reference) : reference_rate;
  return std::max(own, std::min(least, rate.max));
}

Plan build(GraphSpec graph, bool reference) {
  std::vector<Chosen> chosen = choose_types(graph);
  const std::vector<Wire> wires = wires_of(graph);
  Kept kept = prune(graph, wires);
  Diagnostics diagnostics;
  const SourceLocation whole{graph.file.string(), 0, 0};
  const bool ends =
      !graph.record.empty() || std::any_of(graph.nodes.begin(), graph.nodes.end(),
                                           [&graph](const NodeSpec& node) { return is_an_end(graph, node); });
  if (!ends && !reference) {
    diagnostics.error(whole,
                      "expected a sink among the nodes or an output to record, found neither: nothing would run");
  }
  const std::vector<bool> triggers = resolve_triggers(graph, wires, kept);
  for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
    if (!kept.nodes[n] || (reference && only_listens(*graph.nodes[n].info))) continue;
    const std::size_t before = diagnostics.list().size();
    check_required(graph, wires, kept, n, diagnostics);
    if (diagnostics.list().size() == before) check_steps(graph, wires, triggers, n, diagnostics);
    check_hardware(graph, graph.nodes[n], reference, diagnostics);
    if (graph.nodes[n].info->sets) check_settings(graph, kept, graph.nodes[n], diagnostics);
  }
  check_refused(graph, wires, kept, diagnostics);
  check_scene_law(graph, wires, kept, diagnostics);
  check_cycle(graph, wires, kept, triggers, diagnostics);
  diagnostics.throw_if_any();

  Plan plan;
  plan.torque = graph.scene.rotates();
  plan.chosen = std::move(chosen);
  plan.left_out = std::move(kept.left_out);
  std::vector<std::size_t> place(graph.nodes.size(), 0);
  for (const std::size_t n : order_nodes(graph, wires, kept, triggers)) {
    place[n] = plan.nodes.size();
    plan.nodes.push_back(graph.nodes[n]);
  }
  for (std::size_t e = 0; e < wires.size(); ++e) {
    if (!kept.edges[e]) continue;
    const Wire& w = wires[e];
    plan.edges.push_back({graph.edges[e], place[w.from], w.output, place[w.to], w.input, triggers[e]});
  }
  for (const std::string& stream : graph.record) {
    const std::string name = stream.substr(0, stream.find('.'));
    const auto node =
        std::find_if(graph.nodes.begin(), graph.nodes.end(), [&](const auto& s) { return s.name == name; });
    TACTOR_DEMAND(node != graph.nodes.end());
    const auto n = static_cast<std::size_t>(node - graph.nodes.begin());
    if (!kept.nodes[n]) {
      plan.left_out.push_back({"recording " + stream, name + " is left out", LeftOut::Kind::recording});
      continue;
    }
    const OutputInfo* output = node->info->output(stream.substr(name.size() + 1));
    TACTOR_DEMAND(output != nullptr);
    plan.streams.push_back({stream, place[n], static_cast<std::size_t>(output - node->info->outputs.data())});
  }
  plan.graph = std::move(graph);
  return plan;
}

}  // namespace

Plan make_plan(GraphSpec graph) {
  return build(std::move(graph), false);
}

Plan plan_reference(GraphSpec graph) {
  return build(std::move(graph), true);
}

Plan make_reference_plan(const Plan& tested) {
  return plan_reference(reference_graph(tested));
}

GraphSpec reference_graph(const Plan& tested) {
  std::set<std::size_t> nodes;
  std::vector<bool> edges(tested.edges.size(), false);
  std::vector<std::size_t> todo;
  const auto follow = [&](const PlannedEdge& edge, std::size_t e) {
    edges[e] = true;
    if (nodes.insert(edge.from).second) todo.push_back(edge.from);
  };
  for (std::size_t e = 0; e < tested.edges.size(); ++e) {
    const PlannedEdge& edge = tested.edges[e];
    const NodeInfo& reader = *tested.nodes[edge.to].info;
    if (!reader.sink || !reader.inputs[edge.input].reference) continue;
    nodes.insert(edge.to);
    follow(edge, e);
  }
  while (!todo.empty()) {
    const std::size_t n = todo.back();
    todo.pop_back();
    if (only_listens(*tested.nodes[n].info)) continue;
    for (std::size_t e = 0; e < tested.edges.size(); ++e) {
      const PlannedEdge& edge = tested.edges[e];
      if (edge.to == n && tested.nodes[n].info->inputs[edge.input].in_reference) follow(edge, e);
    }
  }

  GraphSpec graph = tested.graph;
  graph.clock = Clock::virtual_;
  graph.record.clear();
  graph.nodes.clear();
  graph.edges.clear();
  for (const std::size_t n : nodes) {
    NodeSpec node = tested.nodes[n];
    node.cost = {};
    node.scheduling = {};
    for (std::size_t i = 0; i < node.params.size(); ++i) {
      if (i == node.info->rate_parameter) {
        node.params[i] = rate_in_reference(*node.info, std::get<double>(node.params[i]));
      } else if (const auto& value = node.info->params[i].in_reference) {
        node.params[i] = *value;
      }
    }
    graph.nodes.push_back(std::move(node));
  }
  for (std::size_t e = 0; e < tested.edges.size(); ++e) {
    if (edges[e]) graph.edges.push_back(tested.edges[e].spec);
  }
  return graph;
}

}  // namespace tactor
