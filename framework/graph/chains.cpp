#include "framework/graph/chains.hpp"

#include <algorithm>
#include <numeric>

namespace tactor {

namespace {

bool is_inner(const Plan& plan, const PlannedEdge& edge) {
  const NodeSpec& from = plan.nodes[edge.from];
  const NodeSpec& to = plan.nodes[edge.to];
  return edge.from != edge.to && from.scheduling.lane == Lane::realtime && from.scheduling == to.scheduling &&
         from.rate() == to.rate() && edge.spec.delay.ns == 0 && edge.spec.queue.policy != QueuePolicy::block &&
         !to.info->sink;
}

}  // namespace

Chains find_chains(const Plan& plan) {
  Chains chains;
  std::vector<std::size_t> first(plan.nodes.size());  // by node: the first one of its chain
  std::iota(first.begin(), first.end(), 0U);
  std::vector<bool> drives;  // by the first node of a chain: a device is in it
  for (const NodeSpec& node : plan.nodes) drives.push_back(node.info->actuator);
  for (const PlannedEdge& edge : plan.edges) {
    const std::size_t a = first[edge.from], b = first[edge.to];
    // One device must not wait for another one's line.
    chains.inner.push_back(is_inner(plan, edge) && (a == b || !drives[a] || !drives[b]));
    if (!chains.inner.back()) continue;
    drives[std::min(a, b)] = drives[a] || drives[b];
    std::replace(first.begin(), first.end(), std::max(a, b), std::min(a, b));
  }
  for (std::size_t n = 0; n < plan.nodes.size(); ++n) {
    chains.of.emplace_back();
    if (plan.nodes[n].scheduling.lane != Lane::realtime) continue;
    chains.of[n] = first[n] < n ? chains.of[first[n]] : chains.nodes.size();
    if (first[n] == n) chains.nodes.emplace_back();
    chains.nodes[*chains.of[n]].push_back(n);
  }
  for (std::vector<std::size_t>& nodes : chains.nodes) {
    std::stable_partition(nodes.begin(), nodes.end(), [&](std::size_t n) { return plan.nodes[n].info->actuator; });
  }
  return chains;
}

std::vector<std::vector<std::size_t>> shared_loops(const Plan& plan) {
  if (plan.graph.clock != Clock::real) return {};
  std::vector<std::vector<std::size_t>> loops = find_chains(plan).nodes;
  std::erase_if(loops, [](const auto& nodes) { return nodes.size() < 2; });
  return loops;
}

std::string node_names(const Plan& plan, const std::vector<std::size_t>& nodes) {
  std::string text;
  for (const std::size_t n : nodes) text += (text.empty() ? "" : ", ") + plan.nodes[n].name;
  return text;
}

}  // namespace tactor
