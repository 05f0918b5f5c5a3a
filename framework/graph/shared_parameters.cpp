// Parameters that are as in another node of the graph, unless the graph gives them.
#include "framework/graph/shared_parameters.hpp"

#include <algorithm>

#include "framework/core/check.hpp"
#include "framework/graph/readers.hpp"
#include "framework/graph/values.hpp"

namespace tactor {

namespace {

/// A parameter of another node, from which one takes its value.
struct Giver {
  std::string path;
  SourceLocation place;
  const ParamValue* value = nullptr;
};

const Tree* given(const Tree& graph, const NodeSpec& node, const std::string& param) {
  return graph.value("nodes")->value(node.name)->value(param);
}

/// Whether a value of the one means the same as one of the other.
bool is_alike(const ParamInfo& a, const ParamInfo& b) {
  return a.name == b.name && a.kind == b.kind && a.unit == b.unit;
}

/// The parameter of the first node of that role that has one alike.
std::optional<Giver> find_giver(const GraphSpec& graph, const Tree& tree, Role role, const ParamInfo& wanted) {
  for (const NodeSpec& node : graph.nodes) {
    if (node.info->role != role) continue;
    const auto& params = node.info->params;
    const auto same =
        std::find_if(params.begin(), params.end(), [&](const ParamInfo& p) { return is_alike(p, wanted); });
    if (same == params.end()) continue;
    const Tree* text = given(tree, node, wanted.name);
    return Giver{.path = "nodes." + node.name + "." + wanted.name,
                 .place = text != nullptr ? text->place : node.place,
                 .value = &node.params[static_cast<std::size_t>(same - params.begin())]};
  }
  return std::nullopt;
}

/// The value as a graph would say it; none where it could not be read, which has its own error.
std::optional<std::string> text_of(const ParamValue& value, ParamKind kind) {
  const auto* real = std::get_if<double>(&value);
  const auto* integer = std::get_if<std::int64_t>(&value);
  const auto* text = std::get_if<std::string>(&value);
  if (kind == ParamKind::real && real != nullptr) return number_text(*real);
  if (kind == ParamKind::integer && integer != nullptr) return std::to_string(*integer);
  const auto* boolean = std::get_if<bool>(&value);
  if (kind == ParamKind::boolean && boolean != nullptr) return *boolean ? "true" : "false";
  const bool is_text = kind == ParamKind::choice || kind == ParamKind::text || kind == ParamKind::file;
  if (is_text && text != nullptr) return *text;
  return std::nullopt;
}

}  // namespace

void read_shared_parameters(GraphSpec& graph, const Tree& tree, const FileFinder& files, Diagnostics& diagnostics) {
  for (NodeSpec& node : graph.nodes) {
    for (std::size_t i = 0; i < node.info->params.size(); ++i) {
      const ParamInfo& param = node.info->params[i];
      if (!param.as_in || given(tree, node, param.name) != nullptr) continue;
      const std::optional<Giver> giver = find_giver(graph, tree, *param.as_in, param);
      if (!giver) continue;
      const std::optional<std::string> text = text_of(*giver->value, param.kind);
      if (!text) continue;
      // It is checked as if the graph said it here.
      Tree as_given;
      as_given.kind = Tree::Kind::scalar;
      as_given.place = giver->place;
      as_given.text = *text;
      const std::string path =
          "nodes." + node.name + "." + param.name + ", as in " + giver->path + " where it is not given";
      if (read_param(as_given, path, param, files, diagnostics)) node.params[i] = *giver->value;
    }
  }
}

namespace {

/// Why no node of the role can be expected to have the parameters of the scene's own physics; empty where one can.
std::string why_not_shared(const GraphSpec& graph, Role role) {
  std::string foreign;
  for (const NodeSpec& node : graph.nodes) {
    const bool is_asked = node.info->role == role, moves = node.info->role == Role::dynamics;
    if ((is_asked || moves) && node.info->scene_law) return {};
    if (is_asked) foreign = node.name + " (" + node.info->type + ")";
  }
  return foreign.empty() ? "the graph has no such node" : foreign + " has none";
}

/// Whether the node reads the parameter in this plan.
bool is_read(const Plan& plan, const NodeSpec& node, const ParamInfo& param) {
  if (!param.unread) return true;
  ParamUse use{.scene = &plan.graph.scene, .read_outputs = {}};
  for (const PlannedEdge& edge : plan.edges) {
    if (edge.spec.from_node == node.name) use.read_outputs.push_back(edge.spec.from_port);
  }
  for (const PlannedStream& stream : plan.streams) {
    const NodeSpec& from = plan.nodes[stream.node];
    if (from.name == node.name) use.read_outputs.push_back(from.info->outputs[stream.output].name);
  }
  return param.unread(node.params, use).empty();
}

bool is_shared(const GraphSpec& graph, const ParamInfo& param) {
  return std::any_of(graph.nodes.begin(), graph.nodes.end(), [&](const NodeSpec& node) {
    const auto& params = node.info->params;
    return node.info->role == *param.as_in &&
           std::any_of(params.begin(), params.end(), [&](const ParamInfo& p) { return is_alike(p, param); });
  });
}

}  // namespace

std::vector<std::string> unshared_parameter_notes(const Plan& plan) {
  const GraphSpec& graph = plan.graph;
  std::vector<std::string> notes;
  for (const NodeSpec& node : plan.nodes) {
    for (std::size_t i = 0; i < node.params.size(); ++i) {
      const ParamInfo& param = node.info->params[i];
      if (param.as_in != Role::dynamics && param.as_in != Role::collision) continue;
      const std::string path = "nodes." + node.name + "." + param.name;
      if (graph.places == nullptr || graph.places->contains(path)) continue;
      if (is_shared(graph, param) || !is_read(plan, node, param)) continue;
      const std::string why = why_not_shared(graph, *param.as_in);
      const std::optional<std::string> value = text_of(node.params[i], param.kind);
      if (why.empty() || !value) continue;
      notes.push_back(node.place.text() + ": node " + node.name + ": " + param.name + " should be as in the " +
                      std::string(name_of(*param.as_in)) + ", and " + why + ": its own default " + *value +
                      (param.unit == "1" ? "" : " " + param.unit) + " counts; give " + node.name + "." + param.name +
                      " to say otherwise");
    }
  }
  return notes;
}

}  // namespace tactor
