// physics.external: where a program that has a simulator of its own puts its results into a graph.
#pragma once

#include "framework/core/engine_state.hpp"
#include "framework/core/messages.hpp"
#include "framework/node/declare.hpp"

namespace tactor {

/// Has no step: a PhysicsLoop takes what waits at its inputs, and sends for it.
class ExternalPhysics final : public Node {
 public:
  struct Params {
    double rate = 0;  // Hz
  };
  ExternalPhysics(const Params& /*params*/, const NodeContext& /*context*/) {}
  static NodeInfo declare();
  void step(StepContext& /*context*/) override {}

  Input<DeviceState> device;
  Input<CouplingParameters> coupling;
  Output<PhysicsState> state;
  Output<BodyStates> bodies;
  Output<ContactSet> contacts;
  Output<Wrench> force;
  Output<EngineState> engine;
};

}  // namespace tactor
