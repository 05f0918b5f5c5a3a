#include "app/view/mouse_graph.hpp"

#include <algorithm>
#include <cstring>

#include "framework/core/messages.hpp"
#include "framework/graph/plan.hpp"
#include "framework/node/registry.hpp"
#include "framework/session/add_feed.hpp"
#include "framework/session/session.hpp"

namespace tactor {

namespace {

constexpr const char* mouse_type = "device.mouse";
/// Every device has shown itself by then.
constexpr Duration first_look{20'000'000};

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// The node and all that its inputs but `segment` are made from.
std::vector<std::string> what_leads(const GraphSpec& graph, const std::string& device) {
  std::vector<std::string> names{device};
  for (std::size_t i = 0; i < names.size(); ++i) {
    for (const EdgeSpec& edge : graph.edges) {
      if (edge.to_node != names[i] || (i == 0 && edge.to_port == "segment") || contains(names, edge.from_node))
        continue;
      names.push_back(edge.from_node);
    }
  }
  return names;
}

/// A device.mouse with the parameters of `old` that both have.
NodeSpec mouse_node(const NodeSpec& old, const Pose& start, Registry& registry) {
  const NodeInfo* info = registry.find(mouse_type);
  if (info == nullptr) throw InputError(std::string("no node library has the type ") + mouse_type);
  NodeSpec node;
  node.name = old.name;
  node.info = info;
  node.place = old.place;
  node.scheduling = old.scheduling;
  const Vec3 turn = to_rotation_vector(start.R);
  for (const ParamInfo& param : info->params) {
    const auto before = old.info->param(param.name);
    if (param.name == "start") {
      node.params.emplace_back(std::vector<double>{start.p.x, start.p.y, start.p.z});
    } else if (param.name == "start_rotation") {
      node.params.emplace_back(std::vector<double>{turn.x, turn.y, turn.z});
    } else if (before && param.name != "dead_man_button") {
      node.params.push_back(old.params[*before]);
    } else {
      node.params.push_back(param.default_value.value());
    }
  }
  // A page leads it no faster than the old device was to be moved.
  const auto keep_below = [&node](const char* follow, const char* limit) {
    double& speed = std::get<double>(node.params[node.info->param(follow).value()]);
    speed = std::min(speed, 0.5 * std::get<double>(node.params[node.info->param(limit).value()]));
  };
  keep_below("follow_speed", "speed_max");
  keep_below("follow_angular_speed", "angular_speed_max");
  return node;
}

}  // namespace

const NodeSpec& device_of(const GraphSpec& graph) {
  const NodeSpec* found = nullptr;
  for (const NodeSpec& node : graph.nodes) {
    if (!node.info->actuator) continue;
    if (found != nullptr) {
      throw InputError("a page controls one device, and the graph has " + found->name + " and " + node.name +
                       "; --device graph keeps them");
    }
    found = &node;
  }
  if (found == nullptr) throw InputError("the graph " + graph.name + " has no device that a page could control");
  return *found;
}

Pose first_handle_pose(const GraphSpec& graph) {
  const NodeSpec& device = device_of(graph);
  const Body* tool = graph.scene.tool();
  Pose pose = tool != nullptr ? tool->X_WB : Pose{};
  if (device.info->hardware) return pose;
  GraphSpec leading = graph;
  const std::vector<std::string> names = what_leads(graph, device.name);
  leading.clock = Clock::virtual_;
  leading.duration = first_look;
  leading.record = {device.name + ".state"};
  std::erase_if(leading.nodes, [&names](const NodeSpec& node) { return !contains(names, node.name); });
  std::erase_if(leading.edges, [&](const EdgeSpec& edge) {
    return !contains(names, edge.from_node) || !contains(names, edge.to_node) || edge.to_port == "segment";
  });
  Session session(make_plan(std::move(leading)));
  const auto state = session.tap(device.name + ".state");
  session.start();
  session.advance(first_look);
  if (const MessageView first = state->take()) {
    DeviceState shown;
    std::memcpy(static_cast<void*>(&shown), first.value, sizeof shown);
    pose = shown.X_WD;
  }
  session.finish();
  return pose;
}

std::string lead_by_mouse(GraphSpec& graph, const Pose& start, Registry& registry) {
  const NodeSpec old = device_of(graph);
  const NodeSpec mouse = mouse_node(old, start, registry);
  std::replace_if(
      graph.nodes.begin(), graph.nodes.end(), [&old](const NodeSpec& node) { return node.name == old.name; }, mouse);
  // What the old device told truly the mouse shows anyway.
  for (EdgeSpec& edge : graph.edges) {
    if (edge.from_node == mouse.name && mouse.info->output(edge.from_port) == nullptr) edge.from_port = "state";
  }
  std::erase_if(graph.edges, [&mouse](const EdgeSpec& edge) {
    return edge.to_node == mouse.name && mouse.info->input(edge.to_port) == nullptr;
  });
  std::erase_if(graph.record, [&mouse](const std::string& output) {
    const std::size_t dot = output.find('.');
    return output.substr(0, dot) == mouse.name && mouse.info->output(output.substr(dot + 1)) == nullptr;
  });
  add_feed(graph, mouse.name + ".cursor", registry);
  return mouse.name;
}

void take_out_sinks(GraphSpec& graph) {
  std::vector<std::string> sinks;
  for (const NodeSpec& node : graph.nodes) {
    if (node.info->sink) sinks.push_back(node.name);
  }
  std::erase_if(graph.edges, [&sinks](const EdgeSpec& edge) { return contains(sinks, edge.to_node); });
  std::erase_if(graph.nodes, [&sinks](const NodeSpec& node) { return contains(sinks, node.name); });
}

}  // namespace tactor
