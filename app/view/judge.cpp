#include "app/view/judge.hpp"

#include <algorithm>

#include "framework/core/check.hpp"
#include "framework/core/messages.hpp"
#include "framework/graph/plan.hpp"
#include "framework/node/registry.hpp"

namespace tactor {

namespace {

constexpr const char* judge_type = "sink.metrics";

/// The first output of type Wrench of a node that `test` likes, as `node.port`; empty where there is none.
template <class Test>
std::string wrench_output(const GraphSpec& graph, const Test& test) {
  for (const NodeSpec& node : graph.nodes) {
    for (const OutputInfo& output : node.info->outputs) {
      if (same_type(*output.type, message_type<Wrench>()) && test(node, output)) return node.name + "." + output.name;
    }
  }
  return {};
}

EdgeSpec edge(const std::string& from, const std::string& to_node, const std::string& to_port) {
  const std::size_t dot = from.find('.');
  EdgeSpec made;
  made.from_node = from.substr(0, dot);
  made.from_port = from.substr(dot + 1);
  made.to_node = to_node;
  made.to_port = to_port;
  return made;
}

/// The graph with a sink that compares the displayed force with that of physics.
GraphSpec judged(GraphSpec graph, Registry& registry) {
  const NodeInfo* info = registry.find(judge_type);
  const std::string truth = wrench_output(graph, [](const NodeSpec& node, const OutputInfo&) {
    return node.info->role == Role::coupling || node.info->role == Role::force_field;
  });
  const std::string displayed = wrench_output(graph, [](const NodeSpec& node, const OutputInfo& output) {
    return node.info->actuator && output.name == "commanded";
  });
  if (info == nullptr || truth.empty() || displayed.empty()) return graph;
  NodeSpec sink;
  sink.name = "judge_of_the_view";
  sink.info = info;
  sink.scheduling = default_scheduling(*info);
  for (const ParamInfo& param : info->params) sink.params.push_back(param.default_value.value());
  for (const InputInfo& input : info->inputs) {
    if (!same_type(*input.type, message_type<Wrench>())) continue;
    if (input.reference) graph.edges.push_back(edge(truth, sink.name, input.name));
    if (input.judged) graph.edges.push_back(edge(displayed, sink.name, input.name));
  }
  graph.nodes.push_back(std::move(sink));
  return graph;
}

}  // namespace

std::unique_ptr<Follower> judging_follower(Session& session, Registry& registry, std::optional<Duration> most_behind,
                                           const std::function<void(const std::string&)>& note) {
  try {
    const Plan whole = make_plan(judged(session.plan().graph, registry));
    return std::make_unique<Follower>(session, registry, Follower::Options{most_behind, &whole});
  } catch (const InputError& error) {
    note(error.what());
    return nullptr;
  }
}

}  // namespace tactor
