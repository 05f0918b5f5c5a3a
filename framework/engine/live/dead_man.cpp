#include "framework/engine/live/dead_man.hpp"

#include "framework/realtime/device_node.hpp"

namespace tactor {

namespace {

/// A node of hardware that is no DeviceNode tells of no button.
bool lacks_dead_man(const NodeSpec& spec, const Node& node) {
  if (!spec.info->hardware) return false;
  const auto* device = dynamic_cast<const DeviceNode*>(&node);
  return device == nullptr || device->lacks_dead_man();
}

std::string name_of(const NodeSpec& spec) {
  return spec.name + " (" + spec.info->type + ")";
}

std::string told_of(const NodeSpec& spec, const DeviceNode& device) {
  const std::int32_t button = device.account().dead_man_button;
  const std::string node = name_of(spec);
  if (button > 0) return "hold button " + std::to_string(button) + " of " + node + " to get a force";
  return "no button stops the force of " + node + ", as its dead_man_button: 0 says";
}

}  // namespace

void check_dead_man(PlanNodes& nodes, const Ask& ask) {
  const Plan& plan = nodes.plan();
  Diagnostics refused;
  std::string names;
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    const NodeSpec& spec = plan.nodes[n];
    if (!lacks_dead_man(spec, nodes[n])) {
      if (spec.info->hardware) nodes.note(told_of(spec, dynamic_cast<const DeviceNode&>(nodes[n])));
      continue;
    }
    names += (names.empty() ? "" : " and ") + name_of(spec);
    refused.error(spec.place,
                  "nodes." + spec.name + ": expected a dead-man button, because " + spec.info->type +
                      " drives hardware, found none: no button stops its force when a person lets go; to do without "
                      "one, start with --no-dead-man (in Python no_dead_man=True), or write dead_man_button: 0");
  }
  if (!refused.any()) return;
  const bool accepted = ask && ask("No button stops the force of " + names + " when you let go. Run all the same?");
  if (!accepted) refused.throw_if_any();
}

}  // namespace tactor
