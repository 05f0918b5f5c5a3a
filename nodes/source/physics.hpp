// source.physics: a recorded force as slow and late as physics would have told it.
#pragma once

#include "framework/core/messages.hpp"
#include "framework/node/declare.hpp"
#include "framework/node/new_messages.hpp"

namespace tactor {

/// Passes on the newest force. Its cost makes it physics: a step that takes 10 ms shows the force of its begin 10 ms
/// later, with the stamp it came with, and the next step begins then.
class PhysicsSource final : public Node {
 public:
  struct Params {};
  PhysicsSource(const Params& /*params*/, const NodeContext& /*context*/) {}
  static NodeInfo declare();
  void step(StepContext& context) override;

  Input<Wrench> recorded;
  Output<Wrench> force;

 private:
  NewMessages<Wrench> new_recorded_;
};

}  // namespace tactor
