// Simulates an engine's scene from each physics result to now.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "framework/core/refusals.hpp"
#include "framework/node/declare.hpp"
#include "nodes/physics/engine/engine_motion.hpp"
#include "nodes/physics/mechanics/handle_track.hpp"
#include "nodes/physics/mechanics/scene_model.hpp"

namespace tactor {

/// What the rollout that goes on from a resimulation may take.
struct RolloutBudget {
  double tick = 0;        ///< s of CPU time, of a tick of the rollout; read for a partial engine alone
  bool measured = false;  ///< the modelled cost of a step is scaled by the CPU time that steps have taken
};

/// For each result: puts the engine into that state, moves it through the samples of the handle since then, and sends
/// where it is by now, stamped as the result.
///
/// Of a partial engine move the tool and the trees near it, as many as the rollout can step within its budget of a tick
/// (see SteppedEngine::near_trees). The others stand where the result has them, here and in the rollout. So the set
/// changes with a result alone, where the rollout blends its force anyway, and a tree that begins to move does so from
/// the pose and the velocity that physics has for it.
///
/// A budget that is not measured chooses by the modelled cost of a step, so a run stays the same on every machine. One
/// that is measured scales the model by the CPU time that steps have taken here, on average over some ten results.
class EngineResimulation {
 public:
  /// `engine` outlives it. `substep`: the longest sub-step, s. The engine may get its model until `prepare`.
  EngineResimulation(SteppedEngine& engine, double substep, const RolloutBudget& budget = {})
      : budget_(budget), motion_(engine, substep) {}
  /// Makes room for the states of the engine as it is. Allocates; before the first step.
  void prepare() { numbers_ = engine_state_pool(motion_.engine(), most_engine_states); }

  void step(Input<EngineState>& result, Input<DeviceState>& device, Output<EngineState>& model);

  /// Of the handle's sample that the engine was moved to.
  [[nodiscard]] Time time() const { return motion_.time(); }
  /// Of the results.
  [[nodiscard]] const Refusals& refusals() const { return refused_; }
  [[nodiscard]] std::uint64_t rejected_samples() const { return track_.rejected(); }
  /// CPU time that a step takes, by its modelled cost; empty where none was measured.
  [[nodiscard]] const std::optional<double>& cost_ratio() const { return cost_ratio_; }
  /// Sub-steps from a result to now, mean of the results.
  [[nodiscard]] double steps_of_a_result() const {
    return results_ > 0 ? static_cast<double>(motion_.steps()) / static_cast<double>(results_) : 0.0;
  }

 private:
  [[nodiscard]] RefusalReason take_result(const Stamped<EngineState>& result, Output<EngineState>& model);
  [[nodiscard]] Trees trees_to_move(const Stamped<EngineState>& result);
  void note_cost(double seconds, std::int64_t steps, Trees moving);

  const RolloutBudget budget_;
  EngineMotion motion_;
  std::unique_ptr<ArrayPool<double>> numbers_;
  HandleTrack<2048> track_;
  Refusals refused_{"results"};
  std::int64_t results_ = 0;
  Time newest_result_;
  double tick_ = 1e-3;                // s, between two samples of the handle
  std::optional<double> cost_ratio_;  // of measured to modelled
};

/// Adds the ports and metrics of a node with the members `engine`, `device`, `model` and resimulation(), and its role.
/// `result`: what the input `engine` is.
template <class N>
void declare_resimulation(Declare<N>& node, const std::string& result) {
  node.input("engine", &N::engine, {.doc = result, .trigger = Trigger::yes})
      .input("device", &N::device, {.doc = "every sample of the handle", .queue = {QueuePolicy::drop_oldest, 2048}})
      .output("model", &N::model, "the same by now, with the stamp of the result")
      .unneeded(nothing_moves)
      .role(Role::prediction)
      .metric("prediction.resimulated_steps", "1", "steps from a result to now, mean of a result", Better::neither,
              [](const N& self) { return self.resimulation().steps_of_a_result(); })
      .metric("prediction.rejected_results", "1", "physics results that were not usable", Better::lower,
              [](const N& self) {
                const Refusals& refused = self.refusals();
                return refused.refused() - refused.refused(RefusalReason::unsolved);
              })
      .summed()
      .metric("prediction.rejected_samples", "1", "samples that were not finite, or too late to be used", Better::lower,
              [](const N& self) { return self.resimulation().rejected_samples(); })
      .summed()
      .metric("prediction.failed_steps", "1", "steps that were not solved", Better::lower,
              [](const N& self) { return self.refusals().refused(RefusalReason::unsolved); })
      .summed();
}

}  // namespace tactor
