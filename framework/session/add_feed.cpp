#include "framework/session/add_feed.hpp"

#include <algorithm>

#include "framework/core/check.hpp"
#include "framework/graph/queue_bounds.hpp"
#include "framework/node/registry.hpp"
#include "framework/yaml/diagnostics.hpp"

namespace tactor {

namespace {

constexpr const char* feed_type = "source.feed";

/// The type and the queue of the input. Throws InputError where there is none.
const InputInfo& find_input(const GraphSpec& graph, const std::string& wanted) {
  std::vector<std::string> names;
  for (const NodeSpec& node : graph.nodes) {
    for (const InputInfo& input : node.info->inputs) {
      names.push_back(node.name + "." + input.name);
      if (names.back() == wanted) return input;
    }
  }
  throw InputError("the graph has no input " + wanted + did_you_mean(wanted, names));
}

/// `feed_device_target`, with a number behind it where the graph has such a node.
std::string free_name(const GraphSpec& graph, std::string input) {
  std::replace(input.begin(), input.end(), '.', '_');
  const std::string name = "feed_" + input;
  std::string free = name;
  for (int n = 2; graph.node(free) != nullptr; ++n) free = name + "_" + std::to_string(n);
  return free;
}

}  // namespace

NodeSpec feed_node(const std::string& name, const MessageType& type, Registry& registry) {
  const NodeInfo* info = registry.find(feed_type);
  if (info == nullptr) throw InputError(std::string("no node library has the type ") + feed_type);
  NodeSpec node;
  node.name = name;
  for (const ParamInfo& param : info->params) {
    node.params.push_back(param.name == "message" ? ParamValue(std::string(type.name)) : param.default_value.value());
  }
  node.info = &with_output_types(*info, node.params);
  node.scheduling = default_scheduling(*node.info);
  return node;
}

void add_feed(GraphSpec& graph, std::string_view input, Registry& registry, std::optional<Queue> queue) {
  const std::string wanted(input);
  const InputInfo& target = find_input(graph, wanted);
  if (queue) check_queue(*queue, *target.type, "the feed into " + wanted);
  NodeSpec node = feed_node(free_name(graph, wanted), *target.type, registry);
  const std::size_t dot = wanted.find('.');
  EdgeSpec edge;
  edge.from_node = node.name;
  edge.from_port = node.info->outputs.front().name;
  edge.to_node = wanted.substr(0, dot);
  edge.to_port = wanted.substr(dot + 1);
  edge.queue = queue.value_or(target.queue);
  edge.queue_is_default = !queue;
  std::erase_if(graph.edges,
                [&](const EdgeSpec& old) { return old.to_node == edge.to_node && old.to_port == edge.to_port; });
  graph.nodes.push_back(std::move(node));
  graph.edges.push_back(std::move(edge));
}

}  // namespace tactor
