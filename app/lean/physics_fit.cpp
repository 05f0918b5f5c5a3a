#include "app/lean/physics_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <nlohmann/json.hpp>
#include <utility>

#include "app/run/summary.hpp"
#include "app/run/timed_run.hpp"
#include "framework/core/check.hpp"
#include "framework/session/session.hpp"

namespace tactor {

namespace {

constexpr double most_simulated = 10;  // s
constexpr std::chrono::milliseconds most_real{2000};

bool is_physics(const NodeSpec& node) {
  return !node.info->fed && (node.info->role == Role::collision || node.info->role == Role::dynamics);
}

/// The graph with a step of physics in every tick, under the virtual clock.
GraphSpec with_physics_in_every_tick(GraphSpec graph) {
  const Duration tick = Duration::from_rate(graph.rate);
  graph.clock = Clock::virtual_;
  graph.duration = std::min(graph.duration, Duration::from_seconds(most_simulated));
  graph.record.clear();
  for (NodeSpec& node : graph.nodes) {
    if (!is_physics(node)) continue;
    node.cost = {};
    if (node.info->role != Role::dynamics) continue;
    // The next step begins with the next sample of the handle.
    node.cost.kind = CostModel::Kind::constant;
    node.cost.base = Duration::from_seconds(0.9 * tick.seconds());
    node.cost.max = tick;
  }
  return graph;
}

void run_for_a_while(Session& session, const std::function<bool()>& interrupted) {
  const auto begin = std::chrono::steady_clock::now();
  constexpr Duration period{10'000'000};
  session.run(period, [&] {
    if (interrupted()) throw Interrupted();
    if (std::chrono::steady_clock::now() - begin >= most_real) session.stop();
  });
}

double sum(const std::vector<PhysicsNode>& nodes, double PhysicsNode::*time) {
  double result = 0;
  for (const PhysicsNode& node : nodes) result += node.*time;
  return result;
}

std::string microseconds(double us) {
  return pretty(us) + " us";
}

}  // namespace

double PhysicsFit::mean_us() const {
  return sum(nodes, &PhysicsNode::mean_us);
}

double PhysicsFit::p99_us() const {
  return sum(nodes, &PhysicsNode::p99_us);
}

std::optional<PhysicsFit> measure_physics_fit(const Plan& plan, const std::function<bool()>& interrupted) {
  const auto moves_bodies = [](const NodeSpec& node) { return is_physics(node) && node.info->role == Role::dynamics; };
  if (std::none_of(plan.nodes.begin(), plan.nodes.end(), moves_bodies)) return std::nullopt;
  PhysicsFit fit;
  fit.tick_us = 1e6 * Duration::from_rate(plan.graph.rate).seconds();
  for (const NodeSpec& node : plan.nodes) {
    if (!is_physics(node) || node.cost.kind == CostModel::Kind::none) continue;
    fit.declared += (fit.declared.empty() ? "" : " and ") + node.name;
  }
  fit.foreign = std::any_of(plan.nodes.begin(), plan.nodes.end(), [&](const NodeSpec& node) {
    return moves_bodies(node) && node.info->is_foreign_physics();
  });
  for (const NodeSpec& node : plan.nodes) {
    if (!node.info->hardware) continue;
    fit.not_measured = node.name + " drives a device";
    return fit;
  }
  const auto not_measured = [&fit](const std::exception& error) {
    fit.nodes.clear();
    fit.not_measured = error.what();
  };
  try {
    Session session(make_plan(with_physics_in_every_tick(plan.graph)), {.engine = {.measure_cpu = true}});
    run_for_a_while(session, interrupted);
    fit.seconds = session.now().seconds();
    const std::vector<double> costs = node_costs(session);
    const std::vector<NodeSpec>& nodes = session.plan().nodes;
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      if (!is_physics(nodes[n])) continue;
      const NodeStatistics found = session.node_statistics(n);
      if (found.steps == 0) throw InputError(nodes[n].name + " made no step");
      fit.nodes.push_back({.node = nodes[n].name,
                           .mean_us = costs[n] * fit.seconds / static_cast<double>(found.steps),
                           .p99_us = 1e-3 * static_cast<double>(found.cpu.quantile(0.99).ns)});
    }
  } catch (const InputError& error) {
    not_measured(error);
  } catch (const RunError& error) {
    not_measured(error);
  }
  return fit;
}

std::string text_of(const PhysicsFit& fit, const std::string& indent) {
  if (!fit.not_measured.empty()) {
    return indent + "How long a step of physics takes was not measured: " + fit.not_measured + "\n";
  }
  std::string parts;
  for (const PhysicsNode& node : fit.nodes) {
    parts += fmt::format("{}{} {}", parts.empty() ? "" : ", ", node.node, pretty(node.mean_us));
  }
  std::string text = fmt::format(
      "{}A step of physics takes {} on average on this machine ({}). 99 % of the steps take less than {}.\n", indent,
      microseconds(fit.mean_us()), parts, microseconds(fit.p99_us()));
  text += fmt::format("{}A tick of the haptic loop is {}, and half of it is left to the other nodes. ", indent,
                      microseconds(fit.tick_us));
  if (fit.fits()) {
    text += "So physics fits into a tick, and no prediction is needed: ";
    text += fit.foreign ? "`--over own_physics/each_tick` makes steps of all of the scene in each tick.\n"
                        : "where nothing deforms, `--over direct` makes a step of physics in each tick.\n";
  } else {
    text += fmt::format(
        "So physics does not fit into a tick: it would have to be {:.1f} times faster. `--over {}` predicts the "
        "force between two steps of physics.\n",
        fit.p99_us() / (fit.tick_us / 2), fit.foreign ? "own_physics/rollout" : "local");
  }
  if (!fit.declared.empty()) {
    text += fmt::format(
        "{}The graph declares a cost of {}. Its runs make each force late by that cost, even where this machine is "
        "faster.\n",
        indent, fit.declared);
  }
  return text;
}

nlohmann::ordered_json to_json(const PhysicsFit& fit) {
  using Json = nlohmann::ordered_json;
  if (!fit.not_measured.empty()) return {{"not_measured", fit.not_measured}, {"tick_us", fit.tick_us}};
  Json json{{"fits", fit.fits()},     {"mean_us", fit.mean_us()},  {"p99_us", fit.p99_us()},
            {"tick_us", fit.tick_us}, {"duration_s", fit.seconds}, {"declared", fit.declared}};
  json["nodes"] = Json::array();
  for (const PhysicsNode& node : fit.nodes) {
    json["nodes"].push_back({{"node", node.node}, {"mean_us", node.mean_us}, {"p99_us", node.p99_us}});
  }
  return json;
}

}  // namespace tactor
