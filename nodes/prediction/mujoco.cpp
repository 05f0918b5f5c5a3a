#include "nodes/prediction/mujoco.hpp"

namespace tactor {

NodeInfo MujocoPredictor::declare() {
  Declare<MujocoPredictor> node("prediction.mujoco", "Simulates MuJoCo's scene from each physics result to now.");
  node.details(
      "A result of physics.mujoco is late by its computing time, and the hand has moved on. The node has a scene of "
      "MuJoCo of its own. It puts it into the state of the result and moves it through the real samples of the handle "
      "since then, by the same steps as physics, but shorter ones. interpolation.mujoco continues from there tick by "
      "tick. Nothing is approximated but the motion of the next tick: contacts, joints and actuators are MuJoCo's "
      "own.\nThe tool moves, and so do the bodies that it touches or may touch before the next result, and those that "
      "these may touch, the nearest first. Bodies that are joined count as one. There are as many as the rollout can "
      "step within `budget`. All others stand where the result has them, and the tool feels them there as fixed "
      "bodies. A run of the virtual clock decides by a model of the cost, so it is the same on every machine. A run by "
      "the machine's clock decides by the time that steps take.\nThe node takes as long for a result as its sub-steps "
      "take; it is not for the real-time lane.\nGoing back to the time of the result comes from the Smith predictor "
      "(O. Smith, 1957).");
  declare_resimulation(node, "all that MuJoCo needs to go on from a result, as physics.mujoco sends it");
  declare_engine_model(node, false, 2.5e-4);
  node.as_in("model", Role::dynamics).as_in("tool", Role::dynamics).as_in("keyframe", Role::dynamics);
  node.real("budget", &Params::budget,
            {.doc = "CPU time that a tick of the rollout may take. It decides how many bodies move; 0: the tool alone. "
                    "The sub-steps of the rollout are taken to be as long as those of this node",
             .unit = "s",
             .default_value = 400e-6,
             .min = 0,
             .max = 1})
      .coarser("substep", {5e-4, 1e-3, 2e-3})
      .metric("prediction.cost_ratio", "1",
              "CPU time that a step takes, by the time that the choice of moving bodies assumes, at the end",
              Better::neither, [](const MujocoPredictor& self) { return self.resimulation_.cost_ratio(); })
      .missing_where("the clock is virtual: the modelled cost decides");
  return node.info();
}

MujocoPredictor::MujocoPredictor(const Params& params, const NodeContext& context)
    : engine_(load_engine("prediction.mujoco", params, context, true)),
      resimulation_(*engine_, params.substep, {.tick = params.budget, .measured = context.wall_clock}) {
  resimulation_.prepare();
}

void MujocoPredictor::step(StepContext& /*context*/) {
  resimulation_.step(engine, device, model);
}

}  // namespace tactor
