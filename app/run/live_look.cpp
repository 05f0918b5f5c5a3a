#include "app/run/live_look.hpp"

#include <cstring>

namespace tactor {

LiveWatch::LiveWatch(Session& session, const Follower* follower) : session_(session), follower_(follower) {
  const Plan& plan = session.plan();
  for (std::size_t n = 0; n < plan.nodes.size(); ++n) {
    if (!plan.nodes[n].info->actuator) continue;
    for (const OutputInfo& output : plan.nodes[n].info->outputs) {
      if (!same_type(*output.type, message_type<SafetyState>())) continue;
      gates_.push_back({n, session.tap(plan.nodes[n].name + "." + output.name, {QueuePolicy::latest, 1}), {}});
    }
  }
}

LiveLook LiveWatch::look() {
  LiveLook look{session_.status(), {}, session_.dropped(), {}};
  if (follower_ != nullptr) look.follower = follower_->figures();
  look.safety.resize(look.status.devices.size());
  for (Gate& gate : gates_) {
    while (const MessageView message = gate.tap->take()) {
      std::memcpy(&gate.last.emplace(), message.value, sizeof(SafetyState));
    }
    for (std::size_t d = 0; d < look.status.devices.size(); ++d) {
      if (look.status.devices[d].node == gate.node) look.safety[d] = gate.last;
    }
  }
  return look;
}

}  // namespace tactor
