#include "nodes/prediction/mujoco.hpp"

#include <algorithm>
#include <cmath>

#include "framework/core/clock.hpp"
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
          "MuJoCo's own.\nThe tool moves, and so do the bodies that it touches or may touch before the next result, "
          "and "
          "those that these may touch, the nearest first. Bodies that are joined count as one. There are as many as "
          "the rollout can step within `budget`. All others stand where the result has them, and the tool feels them "
          "there as fixed bodies. A run of the virtual clock decides by a model of the cost, so it is the same on "
          "every machine. A run by the machine's clock decides by the time that steps take.\nThe node takes as long "
          "for a result as its sub-steps take; it is not for the real-time "
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
  node.real("budget", &Params::budget,
            {.doc = "CPU time that a tick of the rollout may take. It decides how many bodies move; 0: the tool alone. "
                    "The sub-steps of the rollout are taken to be as long as those of this node",
             .unit = "s",
             .default_value = 150e-6,
             .min = 0,
             .max = 1})
      .coarser("substep", {5e-4, 1e-3, 2e-3})
      .metric("prediction.cost_ratio", "1",
              "CPU time that a step takes, by the time that the choice of moving bodies assumes, at the end",
              Better::neither, &MujocoPredictor::cost_ratio_)
      .missing_where("the clock is virtual: the modelled cost decides")
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
    : budget_(params.budget),
      measures_(context.wall_clock),
      motion_(load_engine("prediction.mujoco", params, context, true), params.substep),
      numbers_(engine_state_pool(motion_.engine(), most_engine_states)) {}

void MujocoPredictor::step(StepContext&) {
  track_.take(device);
  const Stamped<EngineState>* result = engine.latest();
  if (result == nullptr || track_.count() == 0) return;
  refused_.count(take_result(*result));
}

/// The trees that the rollout can step within its budget until the next result.
Trees MujocoPredictor::trees_to_move(const Stamped<EngineState>& result) {
  const std::size_t since = track_.after(result.value.time);
  const double age = std::max(0.0, (track_.newest().stamp.valid - result.value.time).seconds());
  if (since < track_.count()) tick_ = age / static_cast<double>(track_.count() - since);
  // The first result comes alone; the next takes about as long as it did.
  const double interval = results_ > 0 ? (result.stamp.valid - newest_result_).seconds() : age;
  const double steps = std::max(1.0, std::ceil(tick_ / motion_.substep() - 1e-6));
  return motion_.near_trees(result.value, track_.newest().value, age + std::max(0.0, interval),
                            budget_ / steps / cost_ratio_.value_or(1));
}

void MujocoPredictor::note_cost(double seconds, std::int64_t steps, Trees moving) {
  const double modelled = static_cast<double>(steps) * motion_.engine().step_cost(moving);
  if (!measures_ || modelled <= 0) return;
  constexpr double share_of_new = 0.1, least = 0.01, most = 100;
  const double ratio = std::clamp(seconds / modelled, least, most);
  cost_ratio_ = cost_ratio_ ? *cost_ratio_ + share_of_new * (ratio - *cost_ratio_) : ratio;
}

/// Sends the result's state, brought on to the newest sample; or why not.
RefusalReason MujocoPredictor::take_result(const Stamped<EngineState>& result) {
  // What the handle did between a result and the samples that are known would be guessed.
  if (track_.first() > 0 && result.value.time < track_[track_.first()].stamp.valid) return RefusalReason::late;
  const Trees moving = trees_to_move(result);
  if (const RefusalReason why = motion_.restart(result.value, moving); why != RefusalReason::none) return why;
  const std::int64_t steps_before = motion_.steps();
  const double begin = measures_ ? clock_seconds(CLOCK_THREAD_CPUTIME_ID) : 0;
  for (std::size_t k = track_.after(motion_.time()); k < track_.count(); ++k) {
    // The display goes on with the model before.
    if (!motion_.advance(track_[k], result.value.coupling)) return RefusalReason::unsolved;
  }
  if (measures_) note_cost(clock_seconds(CLOCK_THREAD_CPUTIME_ID) - begin, motion_.steps() - steps_before, moving);
  const std::optional<EngineState> sent = motion_.state(*numbers_, &result.value);
  if (!sent) return RefusalReason::incomplete;
  model.send(result.stamp.valid, *sent);
  newest_result_ = result.stamp.valid;
  ++results_;
  return RefusalReason::none;
}

}  // namespace tactor
