#include "app/run/run_trace.hpp"

#include <algorithm>
#include <cstring>

#include "framework/session/typed_output.hpp"

namespace tactor {

namespace {

constexpr std::size_t most_events = 1000;

template <class T>
T message_as(const MessageView& message) {
  T value;
  std::memcpy(static_cast<void*>(&value), message.value, sizeof value);
  return value;
}

template <class T>
std::unique_ptr<Session::OutputTap> tap_of(Session& session, const NodeSpec& node, const std::string& name,
                                           std::uint32_t longest) {
  if (typed_output(*node.info, name, message_type<T>()) == nullptr) return nullptr;
  return session.tap(node.name + "." + name, {QueuePolicy::drop_oldest, longest});
}

/// The node that tells where all moving bodies are, else where the tool is.
std::unique_ptr<Session::OutputTap> tap_bodies(Session& session) {
  constexpr std::uint32_t longest = 256;
  const std::vector<NodeSpec>& nodes = session.plan().nodes;
  for (const NodeSpec& node : nodes) {
    if (auto tap = tap_of<BodyStates>(session, node, "bodies", longest)) return tap;
  }
  for (const NodeSpec& node : nodes) {
    if (auto tap = tap_of<PhysicsState>(session, node, "state", longest)) return tap;
  }
  return nullptr;
}

double open_part(const SafetyState& safety) {
  switch (safety.engagement) {
    case Engagement::engaged:
      return 1;
    case Engagement::ramping:
      return safety.gain;
    case Engagement::disengaged:
    case Engagement::fault:
      return 0;
  }
  return 0;
}

}  // namespace

RunTracer::RunTracer(Session& session) : bodies_(tap_bodies(session)) {
  constexpr std::uint32_t longest = 4096;  // of the fastest device in a tenth of a second, with room
  for (const NodeSpec& node : session.plan().nodes) {
    if (!node.info->actuator) continue;
    Device& device = devices_.emplace_back();
    device.name = node.name;
    device.commanded = tap_of<Wrench>(session, node, "commanded", longest);
    device.state = tap_of<DeviceState>(session, node, "state", longest);
    device.safety = tap_of<SafetyState>(session, node, "safety", longest);
  }
}

void RunTracer::attend() {
  take_bodies();
  for (Device& device : devices_) take(device);
}

void RunTracer::take_bodies() {
  if (!bodies_) return;
  if (poses_.size() > 1) poses_.erase(poses_.begin(), poses_.end() - 1);
  while (const MessageView message = bodies_->take()) {
    Poses& poses = poses_.emplace_back();
    poses.time_s = message.stamp->produced.seconds();
    if (same_type(bodies_->type(), message_type<PhysicsState>())) {
      poses.X_WB.push_back(message_as<PhysicsState>(message).X_WT);
      continue;
    }
    const auto bodies = message_as<BodyStates>(message);
    const auto count = static_cast<std::size_t>(std::clamp(bodies.count, 0, BodyStates::capacity));
    poses.X_WB.assign(bodies.X_WB.begin(), bodies.X_WB.begin() + static_cast<std::ptrdiff_t>(count));
  }
}

void RunTracer::take_force(double time_s, const Vec3& force_W) {
  const double force_N = norm(force_W);
  if (!(force_N > 0) || (largest_ && norm(largest_->force_W) >= force_N)) return;
  largest_.emplace(LargestForce{time_s, force_W, {}});
  for (const Poses& poses : poses_) {
    if (poses.time_s <= time_s) largest_->X_WB = poses.X_WB;
  }
}

void RunTracer::take_safety(Device& device, double time_s, const SafetyState& safety) {
  const double open = open_part(safety);
  device.gate.add(time_s, open);
  device.was_open = device.was_open || open > 0;
  // Whether the run lets the gate open is no event.
  const bool keeps_out = safety.cause != SafetyCause::none && safety.cause != SafetyCause::not_permitted;
  if (keeps_out && safety.cause != device.cause && device.was_open) {
    if (device.events.size() < most_events) {
      device.events.push_back({time_s, safety.cause});
    } else {
      ++lost_events_;
    }
  }
  device.cause = safety.cause;
}

void RunTracer::take(Device& device) {
  if (device.commanded) {
    while (const MessageView message = device.commanded->take()) {
      const double time_s = message.stamp->valid.seconds();
      const Vec3 force_W = message_as<Wrench>(message).force;
      device.force.add(time_s, norm(force_W));
      take_force(time_s, force_W);
    }
  }
  if (device.state) {
    while (const MessageView message = device.state->take()) {
      const Vec3 p_WD = message_as<DeviceState>(message).X_WD.p;
      if (!device.began_p_W) device.began_p_W = p_WD;
      device.displacement.add(message.stamp->valid.seconds(), norm(p_WD - *device.began_p_W));
    }
  }
  if (device.safety) {
    while (const MessageView message = device.safety->take()) {
      take_safety(device, message.stamp->valid.seconds(), message_as<SafetyState>(message));
    }
  }
}

RunTrace RunTracer::trace() const {
  RunTrace trace{{}, largest_, lost_events_};
  if (bodies_) trace.lost += bodies_->dropped();
  for (const Device& device : devices_) {
    for (const Tap* tap : {&device.commanded, &device.state, &device.safety})
      trace.lost += *tap ? (*tap)->dropped() : 0;
    trace.devices.push_back({device.name, device.force.series("force", "N"),
                             device.displacement.series("displacement", "m"), device.gate.series("gate", "1"),
                             device.events});
  }
  return trace;
}

}  // namespace tactor
