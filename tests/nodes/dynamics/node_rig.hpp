// A dynamics node with its inputs, driven by milliseconds, in a scene whose tool is a ball.
#pragma once

#include <map>
#include <string>

#include "nodes/dynamics/dynamics_node.hpp"
#include "tests/support/nodes.hpp"

namespace tactor::test {

inline Body ball(const std::string& name, Motion motion) {
  Body body;
  body.name = name;
  body.shape = SphereShape{0.01};
  body.motion = motion;
  return body;
}

/// One ball of 0.1 kg in free space.
inline Scene ball_scene(Motion motion) {
  Scene scene;
  scene.gravity_W = {};
  scene.bodies.push_back(ball("tool", motion));
  return scene;
}

template <class N>
struct NodeRig {
  NodeRig(const typename N::Params& params, Motion motion) : NodeRig(params, ball_scene(motion)) {}
  NodeRig(const typename N::Params& params, Scene s, bool with_contacts = true)
      : scene(std::move(s)), node(params, context_for(scene)) {
    if (with_contacts) node.contacts.configure({});
    node.device.configure({QueuePolicy::drop_oldest, 4096});
    node.coupling.configure({});
    push_law();
  }
  void push_law() { node.coupling.push({}, &coupling); }
  void device(std::int64_t ms, const Vec3& p, const Quat& R = {}) {
    DeviceState d;
    d.X_WD = {p, R};
    node.device.push({Time{ms * 1'000'000}, Time{ms * 1'000'000}, 0}, &d);
  }
  void contacts(std::int64_t ms, const ContactSet& set = {}) {
    node.contacts.push({Time{ms * 1'000'000}, Time{ms * 1'000'000}, 0}, &set);
  }
  std::size_t step(std::int64_t ms) {
    node.state.clear_pending();
    node.bodies.clear_pending();
    node.expected.clear_pending();
    StepContext context(Time{ms * 1'000'000});
    node.step(context);
    return node.state.pending();
  }
  [[nodiscard]] const PhysicsState& state() const { return sent(node.state); }
  [[nodiscard]] std::int64_t valid_ms() const { return node.state.pending_valid(0).ns / 1'000'000; }
  [[nodiscard]] std::map<std::string, double> metrics() const { return metrics_of(node); }

  Scene scene;
  CouplingParameters coupling{.k_t = 500, .b_t = 14, .k_r = 1, .b_r = 0.01, .force_max = 8, .torque_max = 0.3};
  N node;
};

}  // namespace tactor::test
