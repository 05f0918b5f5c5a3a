#include "nodes/prediction/external.hpp"

namespace tactor {

NodeInfo ExternalPredictor::declare() {
  Declare<ExternalPredictor> node("prediction.external",
                                  "Simulates a program's light copy from each of its results to now.");
  node.details(
      "A result of a program's physics is late by its computing time, and the hand has moved on. The program gives the "
      "node a light copy of its simulator, by PhysicsLoop::rollout in C++. The node puts it into the state of the "
      "result and moves it through the real samples of the handle since then, by sub-steps of at most `substep`. "
      "interpolation.external continues from there tick by tick.\nThe node takes as long for a result as its "
      "sub-steps take; it is not for the real-time lane. A step of the copy that throws or is not finite ends the "
      "run.\nGoing back to the time of the result comes from the Smith predictor (O. Smith, 1957).");
  declare_resimulation(node, "the state of a result, as physics.external sends it");
  declare_substep(node);
  return node.info();
}

void ExternalPredictor::take_copy(const LightCopy& copy) {
  engine_.take(copy);
  resimulation_.prepare();
}

void ExternalPredictor::step(StepContext& /*context*/) {
  if (engine.latest() != nullptr) engine_.check_given();
  resimulation_.step(engine, device, model);
  engine_.check_stepped(resimulation_.time());
}

}  // namespace tactor
