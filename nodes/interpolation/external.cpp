#include "nodes/interpolation/external.hpp"

#include "nodes/interpolation/declare_trust.hpp"

namespace tactor {

NodeInfo ExternalRollout::declare() {
  Declare<ExternalRollout> node("interpolation.external",
                                "Continues a program's light copy through each sample of the handle.");
  node.details(
      "It is the display side of prediction.external. The program gives the node a second light copy of its "
      "simulator, by PhysicsLoop::rollout in C++. The node puts it into the newest state and makes one or more "
      "sub-steps per tick. It computes the coupling's wrench from the tool that a sub-step returns, and displays the "
      "wrench and its rate, so the tick until the device shows it adds no delay. When a state arrives, the displayed "
      "force stays as it is. The difference decays as tau^2 e'' + 2 tau e' + e = 0, from a rate between 0 and -e / "
      "tau, so it neither grows nor overshoots. A result is trusted until it is older than `trust_time` and than three "
      "intervals between results; then the last force is held. The same holds if a tick would need more than "
      "`max_substeps`, after a gap in the samples of the handle. The segments tell the device for how long a result is "
      "trusted.\nThe copy runs in the loop of the device, and takes the time that its program gives it. A step "
      "that throws or is not finite ends the run: the force goes to zero, and the message names this node.");
  declare_engine_rollout(node, "the state to continue from, as prediction.external sends it", "the program's copy");
  declare_trust_time(node, "it is no longer continued");
  declare_substep(node);
  return node.info();
}

void ExternalRollout::step(StepContext& context) {
  if (model.latest() != nullptr) engine_.check_given();
  rollout_.step(context.now(), model, device, segment);
  engine_.check_stepped(rollout_.time());
}

}  // namespace tactor
