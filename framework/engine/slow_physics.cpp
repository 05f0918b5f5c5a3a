#include "framework/engine/slow_physics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include "framework/engine/cost.hpp"
#include "framework/graph/texts.hpp"

namespace tactor {

namespace {

/// A parameter in seconds that physics is too slow for.
struct TooShort {
  std::string name;        ///< `device.stale_after`
  double is = 0;           ///< s
  double set = 0;          ///< s, at most what the parameter may be
  bool is_enough = false;  ///< `set` is
};

/// The longest that physics takes for a result, and the nodes whose costs say so.
struct Physics {
  Duration most;
  std::string nodes;  ///< `collision and dynamics`
};

/// Infinite where the node has no such parameter.
double seconds_of(const NodeSpec& node, std::string_view parameter) {
  const std::optional<std::size_t> index = node.info->param(parameter);
  const auto* value = index ? std::get_if<double>(&node.params[*index]) : nullptr;
  return value != nullptr ? *value : std::numeric_limits<double>::infinity();
}

/// The indices of the nodes that the force of a device comes from, through none that makes it by the device's position
/// alone.
std::vector<std::size_t> behind_force_of(const Plan& plan, std::size_t device) {
  std::vector<std::size_t> found;
  const auto add_writers = [&](std::size_t reader, std::string_view input) {
    for (const PlannedEdge& edge : plan.edges) {
      if (edge.to != reader || (!input.empty() && edge.spec.to_port != input)) continue;
      const Role role = plan.nodes[edge.from].info->role;
      if (role == Role::device || role == Role::force_field) continue;
      if (std::find(found.begin(), found.end(), edge.from) == found.end()) found.push_back(edge.from);
    }
  };
  add_writers(device, "segment");
  for (std::size_t i = 0; i < found.size(); ++i) add_writers(found[i], {});
  return found;
}

/// Rounded up to two digits.
double rounded_up(double seconds) {
  const double unit = std::pow(10.0, std::floor(std::log10(seconds)) - 1);
  return std::ceil(seconds / unit - 1e-6) * unit;
}

/// Of those nodes. Collision and dynamics wait for each other.
Physics physics_of(const Plan& plan, const std::vector<std::size_t>& nodes) {
  Physics physics;
  for (const std::size_t n : nodes) {
    const NodeSpec& node = plan.nodes[n];
    const bool steps = node.info->role == Role::collision || node.info->role == Role::dynamics;
    if (!steps || longest(node.cost) <= Duration{}) continue;
    physics.most = physics.most + longest(node.cost);
    physics.nodes += (physics.nodes.empty() ? "" : " and ") + node.name;
  }
  return physics;
}

/// What is too short for results of which one comes every `interval` seconds.
std::vector<TooShort> too_short(const Plan& plan, const NodeSpec& device, const std::vector<std::size_t>& behind,
                                double interval) {
  std::vector<TooShort> found;
  const auto demand = [&](const NodeSpec& node, std::string_view parameter, double least, double wanted) {
    const double is = seconds_of(node, parameter);
    if (is >= least) return;
    const double set = std::min(rounded_up(wanted), node.info->params[*node.info->param(parameter)].max);
    found.push_back({node.name + "." + std::string(parameter), is, set, set >= least});
  };
  // When a result comes its sample is one interval old, and just before the next one two.
  demand(device, "stale_after", interval, 2 * interval);
  demand(device, "sample_age_max", interval, 2 * interval);
  for (const std::size_t n : behind) {
    if (seconds_of(plan.nodes[n], "trust_time") >= 2 * interval) continue;
    demand(plan.nodes[n], "trust_time_max", 2 * interval, 3 * interval);
  }
  return found;
}

/// `a.x is 1 s and b.y is 2 s`.
std::string listed(const std::vector<TooShort>& all, const std::string& verb, double TooShort::*value) {
  std::string text;
  for (const TooShort& one : all) {
    text += (text.empty() ? "" : " and ") + one.name + verb + duration_text(Duration::from_seconds(one.*value));
  }
  return text;
}

}  // namespace

Duration longest(const CostModel& cost) {
  if (cost.kind == CostModel::Kind::none) return {};
  Duration most = cost.base;
  if (cost.kind == CostModel::Kind::trace) most = *std::max_element(cost.trace.begin(), cost.trace.end());
  if (cost.kind == CostModel::Kind::per_item && cost.each > Duration{} && cost.max) most = *cost.max;
  most = Duration::from_seconds(most.seconds() * (1.0 + CostDraw::most_deviations * cost.jitter));
  most = std::max(most, cost.min);
  return cost.max ? std::min(most, *cost.max) : most;
}

std::vector<std::string> slow_physics_notes(const Plan& plan) {
  std::vector<std::string> notes;
  if (plan.graph.clock == Clock::real && !plan.graph.live.impose_cost) return notes;
  for (std::size_t d = 0; d < plan.nodes.size(); ++d) {
    const NodeSpec& device = plan.nodes[d];
    if (!device.info->actuator) continue;
    const std::vector<std::size_t> behind = behind_force_of(plan, d);
    const Physics physics = physics_of(plan, behind);
    if (physics.most <= Duration{}) continue;
    // A result reaches the device a tick or two later.
    const std::vector<TooShort> found = too_short(plan, device, behind, physics.most.seconds() + 2 / plan.graph.rate);
    if (found.empty()) continue;
    const bool can_be_set = std::all_of(found.begin(), found.end(), [](const TooShort& t) { return t.is_enough; });
    notes.push_back(plan.graph.place_of("nodes." + found.front().name).text() + ": node " + device.name +
                    ": physics may take " + duration_text(physics.most) + " by the cost of " + physics.nodes +
                    ", and " + listed(found, " is ", &TooShort::is) + ": the force ramps to zero between results" +
                    (can_be_set ? "; set " + listed(found, " to ", &TooShort::set)
                                : ", whatever they are set to; make physics faster"));
  }
  return notes;
}

}  // namespace tactor
