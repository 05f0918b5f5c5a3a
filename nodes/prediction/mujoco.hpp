// prediction.mujoco: simulates MuJoCo's scene from each physics result to now.
#pragma once

#include <memory>

#include "framework/core/refusals.hpp"
#include "framework/node/declare.hpp"
#include "nodes/physics/engine/engine_node.hpp"
#include "nodes/prediction/engine_resimulation.hpp"

namespace tactor {

/// EngineResimulation with an engine of MuJoCo, whose budget is measured where the run goes by the machine's clock.
class MujocoPredictor final : public Node, public Refusing {
 public:
  struct Params : EngineParams {
    double budget = 0;  // s of CPU time, of a tick of the rollout
  };
  MujocoPredictor(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  void step(StepContext& context) override;
  [[nodiscard]] const Refusals& refusals() const override { return resimulation_.refusals(); }
  [[nodiscard]] const EngineResimulation& resimulation() const { return resimulation_; }

  Input<EngineState> engine;
  Input<DeviceState> device;
  Output<EngineState> model;

 private:
  std::unique_ptr<CoupledEngine> engine_;
  EngineResimulation resimulation_;
};

}  // namespace tactor
