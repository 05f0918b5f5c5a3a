#include <optional>

#include "framework/graph/plan_steps.hpp"

namespace tactor {

namespace {

/// Why `text` cannot be set while the graph runs; empty where it can. `where` names the place in errors of the value.
std::string why_not_settable(const GraphSpec& graph, const Kept& kept, const std::string& text,
                             const std::string& where) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos) return "expected node.parameter=value, found no =";
  const std::string full = text.substr(0, equals);
  const std::string value = text.substr(equals + 1);
  std::vector<std::string> tunable;
  for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
    const NodeSpec& node = graph.nodes[n];
    for (std::size_t p = 0; p < node.info->params.size(); ++p) {
      const ParamInfo& param = node.info->params[p];
      const std::string name = node.name + "." + param.name;
      if (param.tunable && kept.nodes[n]) tunable.push_back(name);
      if (name != full) continue;
      if (!kept.nodes[n]) return "node " + node.name + " is left out: " + kept.node_reasons.at(n);
      if (!param.tunable) return node.info->type + " reads it when it is made; it cannot be set while the run goes on";
      static_cast<void>(parse_parameter(node, p, value, where));
      return {};
    }
  }
  return "the graph has no such parameter" + did_you_mean(full, tunable);
}

}  // namespace

void check_settings(const GraphSpec& graph, const Kept& kept, const NodeSpec& setter, Diagnostics& diagnostics) {
  for (const Setting& setting : setter.info->sets(setter.params)) {
    const std::string path = "nodes." + setter.name + "." + setting.path;
    const SourceLocation place = graph.place_of(path);
    try {
      const std::string why = why_not_settable(graph, kept, setting.text, path);
      if (!why.empty()) diagnostics.error(place, path + ": " + setting.text + ": " + why);
    } catch (const InputError& error) {
      diagnostics.error(place, error.what());
    }
  }
}

}  // namespace tactor
