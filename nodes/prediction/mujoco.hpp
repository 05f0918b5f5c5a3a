// prediction.mujoco: simulates MuJoCo's scene from each physics result to now.
#pragma once

#include <memory>

#include "framework/core/refusals.hpp"
#include "framework/node/declare.hpp"
#include "nodes/physics/engine/engine_motion.hpp"
#include "nodes/physics/engine/engine_node.hpp"
#include "nodes/physics/mechanics/handle_track.hpp"

namespace tactor {

/// For each result of physics.mujoco: puts an engine of its own into that state, moves it through the device samples
/// since then, and sends where it is by now, stamped as the result.
class MujocoPredictor final : public Node, public Refusing {
 public:
  using Params = EngineParams;
  MujocoPredictor(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  void step(StepContext& context) override;
  [[nodiscard]] const Refusals& refusals() const override { return refused_; }

  Input<EngineState> engine;
  Input<DeviceState> device;
  Output<EngineState> model;

 private:
  [[nodiscard]] RefusalReason take_result(const Stamped<EngineState>& result);

  EngineMotion motion_;
  std::unique_ptr<ArrayPool<double>> numbers_;
  HandleTrack<2048> track_;
  Refusals refused_{"results"};
  std::int64_t results_ = 0;
};

}  // namespace tactor
