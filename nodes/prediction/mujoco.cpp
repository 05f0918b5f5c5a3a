#include "nodes/prediction/mujoco.hpp"

#include "nodes/physics/mechanics/scene_model.hpp"

namespace tactor {

NodeInfo MujocoPredictor::declare() {
  Declare<MujocoPredictor> node("prediction.mujoco", "Simulates MuJoCo's scene from each physics result to now.");
  node.details(
          "A result of physics.mujoco is late by its computing time, and the hand has moved on. The node has a scene "
          "of "
          "MuJoCo of its own. It puts it into the state of the result and moves it through the real samples of the "
          "handle since then, by the same steps as physics, but shorter ones. interpolation.mujoco continues from "
          "there "
          "tick by tick. Nothing is approximated but the motion of the next tick: contacts, joints and actuators are "
          "MuJoCo's own.\nThe node takes as long for a result as its sub-steps take; it is not for the real-time "
          "lane.\nGoing back to the time of the result comes from the Smith predictor (O. Smith, 1957).")
      .input(
          "engine", &MujocoPredictor::engine,
          {.doc = "all that MuJoCo needs to go on from a result, as physics.mujoco sends it", .trigger = Trigger::yes})
      .input("device", &MujocoPredictor::device,
             {.doc = "every sample of the handle", .queue = {QueuePolicy::drop_oldest, 2048}})
      .output("model", &MujocoPredictor::model, "the same by now, with the stamp of the result")
      .unneeded(nothing_moves)
      .role(Role::prediction);
  declare_engine_model(node, false, 2.5e-4);
  node.as_in("model", Role::dynamics).as_in("tool", Role::dynamics).as_in("keyframe", Role::dynamics);
  node.coarser("substep", {5e-4, 1e-3, 2e-3})
      .metric("prediction.resimulated_steps", "1", "steps from a result to now, mean of a result", Better::neither,
              [](const MujocoPredictor& self) {
                const auto steps = static_cast<double>(self.motion_.steps());
                return self.results_ > 0 ? steps / static_cast<double>(self.results_) : 0.0;
              })
      .metric("prediction.rejected_results", "1", "physics results that were not usable", Better::lower,
              [](const MujocoPredictor& self) {
                return self.refused_.refused() - self.refused_.refused(RefusalReason::unsolved);
              })
      .summed()
      .metric("prediction.rejected_samples", "1", "samples that were not finite, or too late to be used", Better::lower,
              [](const MujocoPredictor& self) { return self.track_.rejected(); })
      .summed()
      .metric("prediction.failed_steps", "1", "steps that were not solved", Better::lower,
              [](const MujocoPredictor& self) { return self.refused_.refused(RefusalReason::unsolved); })
      .summed();
  return node.info();
}

MujocoPredictor::MujocoPredictor(const Params& params, const NodeContext& context)
    : motion_(load_engine("prediction.mujoco", params, context), params.substep),
      numbers_(engine_state_pool(motion_.engine(), most_engine_states)) {}

void MujocoPredictor::step(StepContext&) {
  track_.take(device);
  const Stamped<EngineState>* result = engine.latest();
  if (result == nullptr || track_.count() == 0) return;
  refused_.count(take_result(*result));
}

/// Sends the result's state, brought on to the newest sample; or why not.
RefusalReason MujocoPredictor::take_result(const Stamped<EngineState>& result) {
  // What the handle did between a result and the samples that are known would be guessed.
  if (track_.first() > 0 && result.value.time < track_[track_.first()].stamp.valid) return RefusalReason::late;
  if (const RefusalReason refusal = motion_.restart(result.value); refusal != RefusalReason::none) return refusal;
  for (std::size_t k = track_.after(motion_.time()); k < track_.count(); ++k) {
    // The display goes on with the model before.
    if (!motion_.advance(track_[k], result.value.coupling)) return RefusalReason::unsolved;
  }
  const std::optional<EngineState> sent = motion_.state(*numbers_, &result.value);
  if (!sent) return RefusalReason::incomplete;
  model.send(result.stamp.valid, *sent);
  ++results_;
  return RefusalReason::none;
}

}  // namespace tactor
