// prediction.mujoco: simulates MuJoCo's scene from each physics result to now.
#pragma once

#include <memory>
#include <optional>

#include "framework/core/refusals.hpp"
#include "framework/node/declare.hpp"
#include "nodes/physics/engine/engine_motion.hpp"
#include "nodes/physics/engine/engine_node.hpp"
#include "nodes/physics/mechanics/handle_track.hpp"

namespace tactor {

/// For each result of physics.mujoco: puts an engine of its own into that state, moves it through the device samples
/// since then, and sends where it is by now, stamped as the result.
///
/// Of the scene move the tool and the trees near it, as many as the rollout can step within its budget of a tick (see
/// CoupledEngine::near_trees). The others stand where the result has them, here and in the rollout. So the set changes
/// with a result alone, where the rollout blends its force anyway, and a tree that begins to move does so from the pose
/// and the velocity that physics has for it.
///
/// The virtual clock chooses by the modelled cost of a step, so a run stays the same on every machine. With the
/// machine's clock, the model is scaled by the CPU time that steps have taken here, on average over some ten results.
class MujocoPredictor final : public Node, public Refusing {
 public:
  struct Params : EngineParams {
    double budget = 0;  // s of CPU time, of a tick of the rollout
  };
  MujocoPredictor(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  void step(StepContext& context) override;
  [[nodiscard]] const Refusals& refusals() const override { return refused_; }

  Input<EngineState> engine;
  Input<DeviceState> device;
  Output<EngineState> model;

 private:
  [[nodiscard]] RefusalReason take_result(const Stamped<EngineState>& result);
  [[nodiscard]] Trees trees_to_move(const Stamped<EngineState>& result);
  void note_cost(double seconds, std::int64_t steps, Trees moving);

  double budget_;
  bool measures_;
  EngineMotion motion_;
  std::unique_ptr<ArrayPool<double>> numbers_;
  HandleTrack<2048> track_;
  Refusals refused_{"results"};
  std::int64_t results_ = 0;
  Time newest_result_;
  double tick_ = 1e-3;                // s, between two samples of the handle
  std::optional<double> cost_ratio_;  // of measured to modelled
};

}  // namespace tactor
