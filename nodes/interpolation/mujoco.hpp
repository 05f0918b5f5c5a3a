// interpolation.mujoco: continues MuJoCo's scene tick by tick.
#pragma once

#include <memory>
#include <string>

#include "framework/core/messages.hpp"
#include "framework/core/refusals.hpp"
#include "framework/node/declare.hpp"
#include "nodes/interpolation/engine_rollout.hpp"
#include "nodes/physics/engine/engine_node.hpp"

namespace tactor {

/// EngineRollout with an engine of MuJoCo, from the states of prediction.mujoco. With `mode: each_tick` and the
/// machine's clock it refuses a model whose steps do not fit into a tick.
class MujocoRollout final : public Node, public Refusing {
 public:
  struct Params : EngineParams, EngineRolloutParams {};
  MujocoRollout(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  void step(StepContext& context) override { rollout_.step(context.now(), model, device, segment); }
  void report(Report& report) const override;
  [[nodiscard]] const Refusals& refusals() const override { return rollout_.refusals(); }
  [[nodiscard]] const EngineRollout& rollout() const { return rollout_; }

  Input<EngineState> model;
  Input<DeviceState> device;
  Output<ForceSegment> segment;

 private:
  static void declare_metrics(Declare<MujocoRollout>& node);
  void refuse_slow_model(const Params& params);

  const std::string name_;
  const bool in_each_tick_;
  std::unique_ptr<CoupledEngine> engine_;
  const int all_bodies_;  // that can move in the scene
  EngineRollout rollout_;
};

}  // namespace tactor
