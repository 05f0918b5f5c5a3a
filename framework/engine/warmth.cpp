#include "framework/engine/warmth.hpp"

#include <algorithm>

#include "framework/core/check.hpp"
#include "framework/engine/virtual_engine.hpp"

namespace tactor {

bool has_to_warm_up(const Plan& plan) {
  return std::any_of(plan.nodes.begin(), plan.nodes.end(),
                     [](const NodeSpec& node) { return !node.info->warm_when.empty(); });
}

Warmth warmth_of(const PlanNodes& nodes) {
  Warmth warmth{Time{}, {}, {}};
  const Plan& plan = nodes.plan();
  for (std::size_t n = 0; n < plan.nodes.size(); ++n) {
    const std::string& when = plan.nodes[n].info->warm_when;
    if (when.empty()) continue;
    const std::optional<Time> since = nodes[n].warm_since();
    if (since && *since <= *warmth.since) continue;
    warmth = {since, plan.nodes[n].name, when};
    if (!since) break;
  }
  return warmth;
}

Warmth find_warmth(const Plan& plan, const std::function<bool()>& go_on) {
  constexpr Duration period{10'000'000};
  VirtualEngine engine(plan);
  const Time end = Time{} + plan.graph.duration;
  engine.start();
  Warmth warmth = warmth_of(engine.nodes());
  while (!warmth.since && engine.now() < end) {
    engine.advance_to(std::min(engine.now() + period, end));
    if (go_on && !go_on()) throw RunError("interrupted");
    warmth = warmth_of(engine.nodes());
  }
  return warmth;
}

}  // namespace tactor
