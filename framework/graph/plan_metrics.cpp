#include "framework/graph/plan_metrics.hpp"

namespace tactor {

NodeMetrics node_metrics(const Plan& plan, std::size_t node, bool reference) {
  const NodeSpec& spec = plan.nodes[node];
  MetricUse use{plan.torque, reference, plan.graph.duration != until_stopped, {}};
  for (const PlannedEdge& edge : plan.edges) {
    if (edge.to == node) use.inputs.push_back(spec.info->inputs[edge.input].name);
  }
  NodeMetrics metrics;
  for (const MetricInfo& metric : spec.info->metrics) {
    std::string why = metric.left_out ? metric.left_out(spec.params, use) : std::string();
    if (why.empty()) {
      metrics.reported.push_back(metric);
    } else {
      metrics.left_out.emplace_back(metric.name, std::move(why));
    }
  }
  return metrics;
}

}  // namespace tactor
