#include "app/run/experiment.hpp"

#include <algorithm>

namespace tactor {

std::optional<std::string> experiment_of(const Plan& plan) {
  const auto leads = [](const NodeSpec& node) { return node.info->sets != nullptr; };
  const auto node = std::find_if(plan.nodes.begin(), plan.nodes.end(), leads);
  return node == plan.nodes.end() ? std::nullopt : std::optional(node->name);
}

}  // namespace tactor
