// prediction.external: moves a program's light copy of its simulator from each physics result to now.
#pragma once

#include "framework/core/light_copy.hpp"
#include "framework/core/refusals.hpp"
#include "framework/node/declare.hpp"
#include "nodes/physics/engine/copy_engine.hpp"
#include "nodes/prediction/engine_resimulation.hpp"

namespace tactor {

/// EngineResimulation with a program's light copy. Throws RunError where a result comes and no program has given one,
/// and where a step of it fails.
class ExternalPredictor final : public Node, public Refusing, public StepsCopy {
 public:
  struct Params {
    double substep = 0;  // s
  };
  ExternalPredictor(const Params& params, const NodeContext& context)
      : engine_(context), resimulation_(engine_, params.substep) {}
  static NodeInfo declare();
  void step(StepContext& context) override;
  void take_copy(const LightCopy& copy) override;
  [[nodiscard]] const Refusals& refusals() const override { return resimulation_.refusals(); }
  [[nodiscard]] const EngineResimulation& resimulation() const { return resimulation_; }

  Input<EngineState> engine;
  Input<DeviceState> device;
  Output<EngineState> model;

 private:
  CopyEngine engine_;
  EngineResimulation resimulation_;
};

}  // namespace tactor
