#include "framework/core/check.hpp"
#include "framework/graph/plan_steps.hpp"

namespace tactor {

std::vector<Chosen> choose_types(GraphSpec& graph) {
  std::vector<Chosen> chosen;
  for (NodeSpec& node : graph.nodes) {
    const NodeInfo& asked = *node.info;
    if (asked.stand_in() == nullptr) continue;
    Resolution resolution = asked.stand_in()->resolve(graph.scene);
    const NodeInfo& info = *resolution.info;
    std::vector<ParamValue> params;
    for (const ParamInfo& param : info.params) {
      const auto given = asked.param(param.name);
      TACTOR_DEMAND(given || param.default_value);
      params.push_back(given ? node.params[*given] : *param.default_value);
    }
    node.info = &info;
    node.params = std::move(params);
    chosen.push_back({node.name, asked.type, info.type, std::move(resolution.reason)});
  }
  return chosen;
}

}  // namespace tactor
