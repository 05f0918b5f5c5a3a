// Physics of another kind, as a user's library has it: its own law of contact, its own names, its own order of ports.
#pragma once

#include <algorithm>
#include <string>

#include "framework/core/messages.hpp"
#include "framework/node/declare.hpp"

namespace tactor::test {

/// A point mass on the spring to the handle, above the floor z = 4 mm, which pushes with the square of the depth.
class ForeignPhysics final : public Node {
 public:
  struct Params {};
  ForeignPhysics(const Params&, const NodeContext& context) : mass_(context.scene->tool()->mass) {}
  static NodeInfo declare() {
    return Declare<ForeignPhysics>("mylab.physics", "A mass on a floor.")
        .output("touching", &ForeignPhysics::touching, "its own contacts")
        .output("where", &ForeignPhysics::where, "the bodies")
        .output("reading", &ForeignPhysics::reading, "the tool")
        .input("spring", &ForeignPhysics::spring, {.doc = "the coupling"})
        .input("hand", &ForeignPhysics::hand,
               {.doc = "the handle", .trigger = Trigger::yes, .queue = {QueuePolicy::drop_oldest, 4096}})
        .role(Role::dynamics)
        .info();
  }
  void step(StepContext&) override {
    Stamped<DeviceState> sample;
    bool any = false;
    while (hand.pop(sample)) {
      if (spring.latest() == nullptr) continue;
      if (!begun_) p_ = sample.value.X_WD.p;
      if (begun_) advance(sample.value, spring.latest()->value, (sample.stamp.valid - last_).seconds());
      last_ = sample.stamp.valid;
      begun_ = any = true;
    }
    if (!any) return;
    BodyStates bodies;
    bodies.count = 1;
    bodies.X_WB[0].p = p_;
    bodies.V_WB[0].v = v_;
    where.send(last_, bodies);
    PhysicsState state;
    state.X_WT.p = p_;
    state.V_WT.v = v_;
    state.X_WD = sample.value.X_WD;
    state.V_WD = sample.value.V_WD;
    state.contact_T_W.force.z = push();
    state.contacts = push() > 0 ? 1 : 0;
    reading.send(last_, state);
  }

  Input<CouplingParameters> spring;
  Input<DeviceState> hand;
  Output<ContactSet> touching;
  Output<BodyStates> where;
  Output<PhysicsState> reading;

 private:
  [[nodiscard]] double push() const {
    const double depth = std::max(0.0, 0.004 - p_.z);
    return 4e5 * depth * depth;
  }
  void advance(const DeviceState& handle, const CouplingParameters& coupling, double time) {
    constexpr int substeps = 20;
    const double h = time / substeps;
    for (int i = 0; i < substeps; ++i) {
      Vec3 force = coupling.k_t * (handle.X_WD.p - p_) + coupling.b_t * (handle.V_WD.v - v_);
      force.z += push();
      v_ += h / mass_ * force;
      p_ += h * v_;
    }
  }

  double mass_;
  Vec3 p_, v_;
  Time last_;
  bool begun_ = false;
};

/// Tells in a note whether dynamics of another law feed it.
class LawListener final : public Node {
 public:
  struct Params {};
  LawListener(const Params&, const NodeContext& context) {
    if (context.notes != nullptr)
      context.notes->push_back(context.foreign_physics ? "foreign law" : "law of the scene");
  }
  static NodeInfo declare() {
    return Declare<LawListener>("mylab.listener", "Listens.")
        .sink()
        .input("bodies", &LawListener::bodies, {.doc = "bodies", .trigger = Trigger::yes})
        .info();
  }
  void step(StepContext&) override {}
  Input<BodyStates> bodies;
};

/// A scene of one moving ball, a floor and this physics. `nodes` and `edges` are lines that come in addition.
inline std::string foreign_scene(const std::string& nodes = "", const std::string& edges = "") {
  return R"(format: 2
title: physics of another kind
duration: 1.2 s
scene:
  gravity: [0, 0, 0]
  bodies:
    floor: {plane: {}}
    tool: {sphere: {radius: 4 mm}, motion: translation, mass: 50 g, pose: {p: [0, 0, 20 mm]}}
nodes:
  trajectory:
    type: source.trajectory
    points: [{t: 0 s, z: 15 mm}, {t: 0.4 s, z: 15 mm}, {t: 0.8 s, z: 2 mm}, {t: 1.2 s, z: 2 mm, x: 20 mm}]
  device: {type: device.simulated, encoder_step: 10 um}
  collision: {type: collision.auto}
  engine: {type: mylab.physics, cost: {constant: 9 ms}}
  coupling: {type: coupling.adaptive}
  prediction: {type: prediction.hold}
  interpolation: {type: interpolation.none}
  metrics: {type: sink.metrics}
)" + nodes +
         R"(edges:
  - trajectory.target -> device.target
  - device.state -> collision.device
  - engine.reading -> collision.state
  - device.state -> engine.hand
  - coupling.parameters -> engine.spring
  - engine.reading -> coupling.state
  - coupling.force -> prediction.force
  - prediction.forecast -> interpolation.forecast
  - interpolation.segment -> device.segment
  - device.commanded -> metrics.commanded
  - coupling.force -> metrics.force
  - prediction.forecast -> metrics.forecast
  - engine.reading -> metrics.state
  - device.state -> metrics.device
)" + edges;
}

}  // namespace tactor::test
