#include "framework/engine/live/actor_steps.hpp"

#include <algorithm>
#include <utility>

namespace tactor {

ActorSteps::ActorSteps(const Plan& plan) : nodes_(plan.nodes.size()) {
  if (!plan.graph.live.impose_cost) return;
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    const NodeSpec& spec = plan.nodes[n];
    nodes_[n].cost.emplace(spec.cost, plan.graph.seed, spec.name);
  }
}

void ActorSteps::begin_ready(Dispatcher& dispatcher) {
  if (ended_) return;
  while (const auto request = dispatcher.next_request()) {
    Node& node = nodes_[request->node];
    node.request = *request;
    node.to_tune = std::move(node.tuned);
    node.tuned.clear();
    woken_.push_back(request->node);
  }
}

bool ActorSteps::hold(std::size_t node, std::int64_t work, Time now) {
  std::optional<CostDraw>& cost = nodes_[node].cost;
  const Time until = nodes_[node].request.now + (cost ? cost->next(work) : Duration{});
  if (until <= now) return false;
  const auto later = [until](const Held& held) { return held.until > until; };
  held_.insert(std::find_if(held_.begin(), held_.end(), later), {until, node});
  return true;
}

std::optional<Time> ActorSteps::held_until() const {
  return held_.empty() ? std::nullopt : std::optional(held_[0].until);
}

std::size_t ActorSteps::release() {
  const std::size_t node = held_[0].node;
  held_.erase(held_.begin());
  return node;
}

bool ActorSteps::is_held(std::size_t node) const {
  return std::any_of(held_.begin(), held_.end(), [node](const Held& held) { return held.node == node; });
}

}  // namespace tactor
