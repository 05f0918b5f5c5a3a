// interpolation.external: continues a program's light copy of its simulator tick by tick.
#pragma once

#include "framework/core/light_copy.hpp"
#include "framework/core/messages.hpp"
#include "framework/core/refusals.hpp"
#include "framework/node/declare.hpp"
#include "nodes/interpolation/engine_rollout.hpp"
#include "nodes/physics/engine/copy_engine.hpp"

namespace tactor {

/// EngineRollout with a program's light copy, from the states of prediction.external. It goes back to each of them.
/// Throws RunError where a state comes and no program has given a copy, and where a step of it fails.
class ExternalRollout final : public Node, public Refusing, public StepsCopy {
 public:
  struct Params : EngineRolloutParams {
    double substep = 0;  // s
  };
  ExternalRollout(const Params& params, const NodeContext& context)
      : engine_(context), rollout_(engine_, params.substep, params, context.torque) {}
  static NodeInfo declare();
  void step(StepContext& context) override;
  void take_copy(const LightCopy& copy) override { engine_.take(copy); }
  [[nodiscard]] const Refusals& refusals() const override { return rollout_.refusals(); }
  [[nodiscard]] const EngineRollout& rollout() const { return rollout_; }

  Input<EngineState> model;
  Input<DeviceState> device;
  Output<ForceSegment> segment;

 private:
  CopyEngine engine_;
  EngineRollout rollout_;
};

}  // namespace tactor
