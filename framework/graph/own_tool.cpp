#include <algorithm>

#include "framework/core/value_error.hpp"
#include "framework/graph/readers.hpp"

namespace tactor {

namespace {

OwnTool tool_of_node(const GraphSpec& graph, const NodeSpec& node) {
  try {
    return node.info->own_tool(node.params);
  } catch (const YamlError&) {
    throw;
  } catch (const InputError& error) {
    const auto* value = dynamic_cast<const ValueError*>(&error);
    const SourceLocation place =
        value == nullptr ? node.place : graph.place_of("nodes." + node.name + "." + value->path());
    throw YamlError({{place, "node " + node.name + ": " + error.what()}});
  }
}

}  // namespace

void take_own_tool(GraphSpec& graph) {
  if (graph.scene.tool() != nullptr) return;
  const auto node = std::find_if(graph.nodes.begin(), graph.nodes.end(),
                                 [](const NodeSpec& one) { return one.info->own_tool != nullptr; });
  if (node == graph.nodes.end()) return;
  OwnTool tool = tool_of_node(graph, *node);
  const auto is_taken = [&](const Body& body) { return body.name == tool.body.name; };
  if (std::any_of(graph.scene.bodies.begin(), graph.scene.bodies.end(), is_taken)) {
    const std::string path = "scene.bodies." + tool.body.name;
    throw YamlError({{graph.place_of(path), path + ": node " + node->name + " (" + node->place.text() +
                                                ") has a tool of this name, and here is a body that does not move; "
                                                "rename it or take it out"}});
  }
  if (!graph.places || !graph.places->contains("scene.gravity")) graph.scene.gravity_W = tool.gravity_W;
  graph.scene.bodies.push_back(std::move(tool.body));
}

}  // namespace tactor
