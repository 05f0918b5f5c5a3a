// physics.mujoco: MuJoCo as the physics of a graph.
#pragma once

#include <memory>

#include "framework/core/body_poses.hpp"
#include "framework/core/handle_gate.hpp"
#include "framework/core/refusals.hpp"
#include "framework/node/declare.hpp"
#include "framework/node/new_messages.hpp"
#include "nodes/physics/engine/engine_motion.hpp"
#include "nodes/physics/engine/engine_node.hpp"

namespace tactor {

/// Moves a model of MuJoCo through every sample of the handle, with its tool on the coupling. Throws RunError where
/// MuJoCo fails or its scene becomes unstable, and at a coupling of a massless tool.
class MujocoPhysics final : public Node, public Refusing {
 public:
  struct Params : EngineParams {
    bool start_at_device = true;
  };
  MujocoPhysics(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  void step(StepContext& context) override;
  [[nodiscard]] const Refusals& refusals() const override { return gate_.refusals(); }

  Input<DeviceState> device;
  Input<CouplingParameters> coupling;
  Output<PhysicsState> state;
  Output<BodyStates> bodies;
  Output<ContactSet> contacts;
  Output<EngineState> engine;
  Output<BodyPoses> poses;

 private:
  void send();
  void send_poses(Time time);

  std::string name_;
  bool start_at_device_;
  std::unique_ptr<CoupledEngine> engine_;
  EngineMotion motion_;
  std::unique_ptr<ArrayPool<double>> numbers_;
  ArrayPool<ShownPose> shown_;
  NewMessages<DeviceState> new_samples_;
  HandleGate gate_;
  ContactSet found_;
  bool begun_ = false;
  std::int64_t dropped_states_ = 0;
};

}  // namespace tactor
