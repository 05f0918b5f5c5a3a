#include <algorithm>

#include "framework/fields/write_fields.hpp"
#include "framework/graph/format.hpp"
#include "framework/graph/live_fields.hpp"
#include "framework/graph/scene_fields.hpp"
#include "framework/graph/scheduling_words.hpp"
#include "framework/graph/spec.hpp"
#include "framework/graph/texts.hpp"
#include "framework/graph/values.hpp"

namespace tactor {

namespace {

std::string seconds(Duration duration) {
  return number_text(duration.seconds());
}

struct WriteValue {
  std::string operator()(std::monostate) const { return "~"; }
  std::string operator()(bool value) const { return value ? "true" : "false"; }
  std::string operator()(std::int64_t value) const { return std::to_string(value); }
  std::string operator()(double value) const { return number_text(value); }
  std::string operator()(const std::string& value) const { return yaml_quoted(value); }
  std::string operator()(const std::vector<double>& values) const { return yaml_list(values); }
  std::string operator()(const Table& table) const {
    if (table.rows() == 0) return "[]";
    std::string text;
    for (std::size_t r = 0; r < table.rows(); ++r) {
      const auto first = table.values.begin() + static_cast<std::ptrdiff_t>(r * table.columns);
      text += "\n      - " + yaml_list({first, first + static_cast<std::ptrdiff_t>(table.columns)});
    }
    return text;
  }
  std::string operator()(const Mapping& mapping) const {
    if (mapping.empty()) return "{}";
    std::string text;
    for (const auto& [key, value] : mapping) text += "\n      " + yaml_quoted(key) + ": " + yaml_quoted(value);
    return text;
  }
};

std::string write_cost(const CostModel& cost) {
  if (cost.kind == CostModel::Kind::none) return "none";
  if (cost.kind == CostModel::Kind::trace) return "{trace: " + yaml_quoted(cost.trace_file.string()) + "}";
  std::string text = cost.kind == CostModel::Kind::constant
                         ? "{constant: " + seconds(cost.base)
                         : "{per_contact: " + seconds(cost.each) + ", base: " + seconds(cost.base);
  text += ", jitter: " + number_text(cost.jitter) + ", min: " + seconds(cost.min);
  if (cost.max) text += ", max: " + seconds(*cost.max);
  return text + "}";
}

/// A line for each entry.
std::string lines(const std::vector<FieldWriter::Entry>& entries, const std::string& indent) {
  std::string text;
  for (const auto& [key, value] : entries) text += indent + key + ": " + value + "\n";
  return text;
}

/// The entries that `before` does not have so.
std::vector<FieldWriter::Entry> changed(std::vector<FieldWriter::Entry> now,
                                        const std::vector<FieldWriter::Entry>& before) {
  std::erase_if(now, [&](const auto& entry) { return std::find(before.begin(), before.end(), entry) != before.end(); });
  return now;
}

std::string write_scheduling(const Scheduling& scheduling) {
  std::string text = "    lane: " + word(scheduling.lane) + "\n";
  if (!scheduling.thread.empty()) text += "    thread: " + scheduling.thread + "\n";
  if (scheduling.policy) text += "    policy: " + word(*scheduling.policy) + "\n";
  if (scheduling.priority) text += "    priority: " + std::to_string(*scheduling.priority) + "\n";
  if (scheduling.cpu) text += "    cpu: " + std::to_string(*scheduling.cpu) + "\n";
  return text;
}

std::string write_value(const NodeSpec& node, std::size_t i) {
  const std::string value = std::visit(WriteValue{}, node.params[i]);
  return "    " + node.info->params[i].name + ":" + (value.starts_with('\n') ? "" : " ") + value + "\n";
}

/// Whether the parameter has the rate of the haptic loop, which the graph gives.
bool is_rate_of(const GraphSpec& graph, const NodeSpec& node, std::size_t i) {
  return node.info->haptic_rate && i == node.info->rate_parameter && node.params[i] == ParamValue(graph.rate);
}

std::string write_type(const NodeInfo& info) {
  return info.python.empty() ? "    type: " + info.type + "\n" : "    python: " + yaml_quoted(info.python) + "\n";
}

std::string write_node(const GraphSpec& graph, const NodeSpec& node) {
  std::string text = "  " + node.name + ":\n" + write_type(*node.info);
  for (std::size_t i = 0; i < node.params.size(); ++i) {
    const bool chooses = std::holds_alternative<std::monostate>(node.params[i]);
    if (!chooses && !is_rate_of(graph, node, i)) text += write_value(node, i);
  }
  return text + "    cost: " + write_cost(node.cost) + "\n" + write_scheduling(node.scheduling);
}

std::string write_edge(const EdgeSpec& edge) {
  std::string text =
      "  - {from: " + edge.from_node + "." + edge.from_port + ", to: " + edge.to_node + "." + edge.to_port;
  if (!edge.queue_is_default) text += ", queue: " + yaml_quoted(queue_text(edge.queue));
  if (edge.delay.ns > 0) text += ", delay: " + seconds(edge.delay);
  return text + "}\n";
}

/// A node whose type is another: a file that extends takes nothing over then.
std::string overlay_new_type(const GraphSpec& graph, const NodeSpec& to) {
  std::string text = write_type(*to.info);
  for (std::size_t i = 0; i < to.params.size(); ++i) {
    const bool is_default = to.info->params[i].default_value == to.params[i];
    if (!is_default && !is_rate_of(graph, to, i)) text += write_value(to, i);
  }
  if (to.cost.kind != CostModel::Kind::none) text += "    cost: " + write_cost(to.cost) + "\n";
  if (write_scheduling(to.scheduling) != write_scheduling(default_scheduling(*to.info))) {
    text += write_scheduling(to.scheduling);
  }
  return text;
}

std::string overlay_node(const GraphSpec& graph, const NodeSpec& from, const NodeSpec& to) {
  std::string text;
  if (from.info != to.info) {
    text = overlay_new_type(graph, to);
  } else {
    for (std::size_t i = 0; i < to.params.size(); ++i) {
      if (from.params[i] != to.params[i] && !is_rate_of(graph, to, i)) text += write_value(to, i);
    }
    if (write_cost(from.cost) != write_cost(to.cost)) text += "    cost: " + write_cost(to.cost) + "\n";
    if (write_scheduling(from.scheduling) != write_scheduling(to.scheduling)) text += write_scheduling(to.scheduling);
  }
  return text.empty() ? text : "  " + to.name + ":\n" + text;
}

std::string overlay_body(const Body& from, const Body& to) {
  const std::string text = lines(changed(written_fields(to), written_fields(from)), "      ");
  return text.empty() ? text : "    " + to.name + ":\n" + text;
}

/// The parts of `to` told against those of `from` of the same name.
template <class Part, class Tell>
std::string overlay_parts(const std::vector<Part>& from, const std::vector<Part>& to, const Tell& tell) {
  std::string text;
  for (const Part& part : to) {
    for (const Part& before : from) {
      if (before.name == part.name) text += tell(before, part);
    }
  }
  return text;
}

}  // namespace

std::string to_overlay(const GraphSpec& from, const GraphSpec& to, const std::string& title,
                       const std::vector<std::string>& extends) {
  std::string files;
  for (const std::string& file : extends) files += (files.empty() ? "" : ", ") + yaml_quoted(file);
  std::string text = "title: " + yaml_quoted(title) + "\nextends: [" + files + "]\n";
  if (from.rate != to.rate) text += "rate: " + number_text(to.rate) + "\n";
  const std::string bodies = overlay_parts(from.scene.bodies, to.scene.bodies, overlay_body);
  if (!bodies.empty()) text += "scene:\n  bodies:\n" + bodies;
  const std::string nodes = overlay_parts(from.nodes, to.nodes, [&to](const NodeSpec& before, const NodeSpec& node) {
    return overlay_node(to, before, node);
  });
  if (!nodes.empty()) text += "nodes:\n" + nodes;
  std::string edges;
  for (const EdgeSpec& edge : from.edges) {
    const auto same = [&edge](const EdgeSpec& e) { return e.name() == edge.name(); };
    if (std::none_of(to.edges.begin(), to.edges.end(), same)) edges += "  - " + edge.name() + ": ~\n";
  }
  return edges.empty() ? text : text + "edges:\n" + edges;
}

std::string to_yaml(const GraphSpec& spec) {
  std::string text = "format: " + std::to_string(file_format) + "\n";
  if (!spec.title.empty()) text += "title: " + yaml_quoted(spec.title) + "\n";
  text += std::string("clock: ") + (spec.clock == Clock::real ? "real" : "virtual") + "\n";
  text +=
      "duration: " + (spec.duration == until_stopped ? duration_text(spec.duration) : seconds(spec.duration)) + "\n";
  text += "seed: " + std::to_string(spec.seed) + "\n";
  text += "rate: " + number_text(spec.rate) + "\n";
  text += "live:\n" + lines(written_fields(spec.live), "  ");
  text += "scene:\n";
  Scene scene = spec.scene;
  scene.bodies.clear();
  text += lines(written_fields(scene), "  ");
  text += spec.scene.bodies.empty() ? "  bodies: {}\n" : "  bodies:\n";
  for (const Body& body : spec.scene.bodies) text += "    " + body.name + ":\n" + lines(written_fields(body), "      ");
  text += "nodes:\n";
  for (const NodeSpec& node : spec.nodes) text += write_node(spec, node);
  text += spec.edges.empty() ? "edges: []\n" : "edges:\n";
  for (const EdgeSpec& edge : spec.edges) text += write_edge(edge);
  text += spec.record.empty() ? "record: []\n" : "record:\n";
  for (const std::string& stream : spec.record) text += "  - " + stream + "\n";
  return text;
}

}  // namespace tactor
