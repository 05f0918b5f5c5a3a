// Parameters that are as in another node of the graph, unless the graph gives them.
#include <algorithm>

#include "framework/graph/readers.hpp"

namespace tactor {

namespace {

const ParamValue* value_in(const GraphSpec& graph, Role role, const std::string& name) {
  for (const NodeSpec& node : graph.nodes) {
    if (node.info->role != role) continue;
    const auto& params = node.info->params;
    const auto same = std::find_if(params.begin(), params.end(), [&](const ParamInfo& p) { return p.name == name; });
    if (same != params.end()) return &node.params[static_cast<std::size_t>(same - params.begin())];
  }
  return nullptr;
}

}  // namespace

void read_shared_parameters(GraphSpec& graph, const Tree& tree) {
  for (NodeSpec& node : graph.nodes) {
    for (std::size_t i = 0; i < node.info->params.size(); ++i) {
      const ParamInfo& param = node.info->params[i];
      if (!param.as_in || tree.value("nodes")->value(node.name)->value(param.name) != nullptr) continue;
      if (const ParamValue* value = value_in(graph, *param.as_in, param.name)) node.params[i] = *value;
    }
  }
}

}  // namespace tactor
