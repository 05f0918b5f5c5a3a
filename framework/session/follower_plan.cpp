#include "framework/session/follower_plan.hpp"

#include <algorithm>
#include <map>
#include <optional>

#include "framework/core/check.hpp"
#include "framework/core/messages.hpp"
#include "framework/session/add_feed.hpp"
#include "framework/session/typed_output.hpp"

namespace tactor {

namespace {

/// Another second, so that what was sent at the very end is followed too.
constexpr Duration longer{1'000'000'000};

bool is_wrench(const InputInfo& input) {
  return same_type(*input.type, message_type<Wrench>());
}

/// The output whose edge ends at an input of the node that `test` likes.
template <class Test>
std::optional<std::string> output_into(const Plan& plan, std::size_t node, const Test& test) {
  for (const PlannedEdge& edge : plan.edges) {
    if (edge.to != node || !test(plan.nodes[node].info->inputs[edge.input])) continue;
    return edge.spec.from_node + "." + edge.spec.from_port;
  }
  return std::nullopt;
}

}  // namespace

FollowerPlan plan_follower(const Plan& tested, Registry& registry) {
  FollowerPlan follower;
  for (std::size_t n = 0; n < tested.nodes.size() && follower.reference.empty(); ++n) {
    const auto truth =
        output_into(tested, n, [](const InputInfo& input) { return input.reference && is_wrench(input); });
    const auto judged = output_into(tested, n, [](const InputInfo& input) { return input.judged && is_wrench(input); });
    if (!truth || !judged) continue;
    follower.reference = *truth;
    follower.judged = *judged;
    const NodeSpec& sink = tested.nodes[n];
    if (const auto mass = sink.info->param("mass")) follower.handle_mass = std::get<double>(sink.params[*mass]);
  }
  if (follower.reference.empty()) {
    throw InputError(
        "no reference can follow this run: none of its nodes compares a force with a reference, as sink.metrics does");
  }
  GraphSpec graph = reference_graph(tested);
  graph.duration = graph.duration + longer;
  graph.record = {follower.reference};
  std::map<std::string, std::string> feeds;  // output of a device -> node
  std::vector<NodeSpec> added;
  for (EdgeSpec& edge : graph.edges) {
    const NodeSpec& from = *graph.node(edge.from_node);
    if (!from.info->actuator) continue;
    const OutputInfo& output = *from.info->output(edge.from_port);
    const auto [feed, fresh] =
        feeds.try_emplace(edge.from_node + "." + edge.from_port, edge.from_node + "_" + edge.from_port);
    if (fresh) {
      added.push_back(feed_node(feed->second, *output.type, registry));
      const OutputInfo* truth = typed_output(*from.info, "truth", *output.type);
      follower.fed.push_back({edge.from_node + "." + (truth != nullptr ? *truth : output).name, feed->second});
    }
    edge.from_node = feed->second;
    edge.from_port = added.back().info->outputs.front().name;
  }
  const auto goes = [&graph](const std::string& name) {
    const NodeSpec* node = graph.node(name);
    return node != nullptr && (node->info->actuator || node->info->sink);
  };
  std::erase_if(graph.edges, [&](const EdgeSpec& edge) { return goes(edge.to_node); });
  std::erase_if(graph.nodes, [](const NodeSpec& node) { return node.info->actuator || node.info->sink; });
  graph.nodes.insert(graph.nodes.end(), added.begin(), added.end());
  follower.plan = plan_reference(std::move(graph));
  for (const NodeSpec& node : follower.plan.nodes) {
    const bool ours =
        std::any_of(added.begin(), added.end(), [&](const NodeSpec& feed) { return feed.name == node.name; });
    if (ours || (!node.info->fed && !node.info->rate_parameter)) continue;
    throw InputError("no reference can follow this run: its physics depends on node " + node.name + " (" +
                     node.info->type + "), which no device shows");
  }
  return follower;
}

}  // namespace tactor
