// interpolation.mujoco: continues MuJoCo's scene tick by tick.
#pragma once

#include <string>

#include "framework/core/messages.hpp"
#include "framework/core/refusals.hpp"
#include "framework/node/declare.hpp"
#include "nodes/interpolation/blended_force.hpp"
#include "nodes/interpolation/model_intake.hpp"
#include "nodes/interpolation/moved_bodies.hpp"
#include "nodes/interpolation/rollout_trust.hpp"
#include "nodes/physics/engine/engine_motion.hpp"
#include "nodes/physics/engine/engine_node.hpp"
#include "nodes/physics/mechanics/handle_track.hpp"

namespace tactor {

/// Moves an engine of its own from the newest state of prediction.mujoco through each sample of the handle. Displays
/// the coupling's wrench, carried on to the time of display, and blends where a state arrives, as Rollout does. A state
/// is trusted as in Rollout. Where it is older, a step failed, or a tick would need more than `max_substeps`, the last
/// trusted force is held until a state comes that can be gone on with.
///
/// With `restart: on_disagreement` the scene stays as the rollout has it until physics has the tool elsewhere for
/// longer than the patience, or farther than is trusted. The tool has to be all that moves in the scene for that.
///
/// The state says which trees of the scene move; the others stand where it has them.
///
/// With `mode: each_tick` all of the scene moves, from the first state on through every sample of the handle, and later
/// states are compared with it alone. Nothing is predicted then. After a step that failed, the next state is a new
/// start.
class MujocoRollout final : public Node, public Refusing {
 public:
  struct Params : EngineParams, TrustOptions {
    Duration blend_time;
    double rate = 0;
    enum class Mode { rollout, each_tick };
    Mode mode = Mode::rollout;
    enum class Restart { always, on_disagreement };
    Restart restart = Restart::always;
    std::int32_t max_substeps = 0;  // of a tick
  };
  MujocoRollout(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  void step(StepContext& context) override;
  void report(Report& report) const override;
  [[nodiscard]] const Refusals& refusals() const override { return intake_.refusals(); }

  Input<EngineState> model;
  Input<DeviceState> device;
  Output<ForceSegment> segment;

 private:
  static void declare_metrics(Declare<MujocoRollout>& node);
  bool take_model(Time now);
  [[nodiscard]] RefusalReason take_state(const EngineState& state, bool keep);
  [[nodiscard]] bool may_keep() const;
  void go_on();
  void advance_to(const Stamped<DeviceState>& sample);
  void note_state();
  void refuse_slow_model();
  [[nodiscard]] Wrench wrench() const;
  [[nodiscard]] bool trusted(Time now) const;

  [[nodiscard]] bool in_each_tick() const { return params_.mode == Params::Mode::each_tick; }
  /// In each tick, the scene may not have gone through all samples yet: at its begin, or after a gap.
  [[nodiscard]] bool lags() const { return in_each_tick() && advanced_ < track_.count(); }

  const std::string name_;
  const Params params_;
  const bool torque_;
  const Duration tick_;
  EngineMotion motion_;
  const int all_bodies_;         // that can move in the scene
  CouplingParameters coupling_;  // of the newest state
  CarriedForce carried_;
  BlendedForce blended_;
  HandleTrack<256> track_;
  std::size_t advanced_ = 0;  // samples that the engine has been through
  ModelIntake intake_;
  RolloutTrust trust_;
  MovedBodies moved_;
  bool failed_ = false;  // a step has, since the state came
  bool held_ = false;    // at the last tick
  Wrench held_wrench_;   // within the device's limits
  Wrench result_wrench_;
  std::int64_t rolled_ticks_ = 0, held_ticks_ = 0, failed_steps_ = 0, overruns_ = 0;
};

}  // namespace tactor
