// Parameters that are as in another node of the graph, unless the graph gives them.
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
  if (kind == ParamKind::choice && text != nullptr) return *text;
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

}  // namespace tactor
