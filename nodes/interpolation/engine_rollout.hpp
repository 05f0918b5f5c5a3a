// Continues the scene of an engine tick by tick.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "framework/core/messages.hpp"
#include "framework/core/refusals.hpp"
#include "framework/node/declare.hpp"
#include "nodes/interpolation/blended_force.hpp"
#include "nodes/interpolation/model_intake.hpp"
#include "nodes/interpolation/moved_bodies.hpp"
#include "nodes/interpolation/rollout_display.hpp"
#include "nodes/interpolation/rollout_trust.hpp"
#include "nodes/physics/engine/engine_motion.hpp"
#include "nodes/physics/mechanics/handle_track.hpp"
#include "nodes/physics/mechanics/scene_model.hpp"

namespace tactor {

/// The parameters of such a rollout.
struct EngineRolloutParams : TrustOptions {
  Duration blend_time;
  double rate = 0;  ///< Hz
  enum class Mode { rollout, each_tick };
  Mode mode = Mode::rollout;
  enum class Restart { always, on_disagreement };
  Restart restart = Restart::always;
  std::int32_t max_substeps = 0;  ///< of a tick
};

/// Moves an engine from the newest state of a resimulation through each sample of the handle. Displays the coupling's
/// wrench, carried on to the time of display, and blends where a state arrives, as Rollout does. A state is trusted as
/// in Rollout. Where it is older, a step failed, or a tick would need more than `max_substeps`, the last trusted force
/// is held until a state comes that can be gone on with. Where a part of the scene stands, and physics' results have
/// been nearer to a held result than to the rollout, the newest result's force is held.
///
/// With `restart: on_disagreement` the scene stays as the rollout has it until physics has the tool elsewhere for
/// longer than the patience, or farther than is trusted. The tool has to be all that moves in the scene for that.
///
/// The state says which trees of the scene move; the others stand where it has them.
///
/// With `mode: each_tick` all of the scene moves, from the first state on through every sample of the handle, and later
/// states are compared with it alone. Nothing is predicted then. After a step that failed, the next state is a new
/// start.
class EngineRollout {
 public:
  /// `engine` outlives it. `substep`: the longest sub-step, s.
  EngineRollout(SteppedEngine& engine, double substep, const EngineRolloutParams& params, bool torque);

  void step(Time now, Input<EngineState>& model, Input<DeviceState>& device, Output<ForceSegment>& segment);

  /// Of the states.
  [[nodiscard]] const Refusals& refusals() const { return intake_.refusals(); }
  /// Of the handle's sample that the engine was moved to.
  [[nodiscard]] Time time() const { return motion_.time(); }
  [[nodiscard]] std::int64_t rolled_ticks() const { return ticks(Source::rollout); }
  /// Ticks that held a force, and those of them at which a held result has been nearer to physics.
  [[nodiscard]] std::int64_t held_ticks() const { return ticks(Source::held) + outdone_ticks(); }
  [[nodiscard]] std::int64_t outdone_ticks() const { return ticks(Source::result); }
  [[nodiscard]] std::int64_t failed_steps() const { return failed_steps_; }
  /// Times that more sub-steps were due than `max_substeps`.
  [[nodiscard]] std::int64_t overruns() const { return overruns_; }
  /// Sub-steps.
  [[nodiscard]] std::int64_t steps() const { return motion_.steps(); }
  [[nodiscard]] std::uint64_t rejected_samples() const { return track_.rejected(); }
  [[nodiscard]] const RolloutTrust& trust() const { return trust_; }
  /// Bodies that the states which were restarted from let move.
  [[nodiscard]] const MovedBodies& moved() const { return moved_; }
  [[nodiscard]] double correction_rms() const { return display_.correction_rms(); }

 private:
  /// The force of a tick: the rollout's, the last trusted one, or that of the newest result.
  enum class Source : std::uint8_t { rollout, held, result };
  [[nodiscard]] Source source_now(Time now) const;
  [[nodiscard]] std::int64_t ticks(Source source) const { return ticks_[static_cast<std::size_t>(source)]; }
  bool take_model(const Stamped<EngineState>& newest, Time now);
  [[nodiscard]] RefusalReason take_state(const EngineState& state, bool keep);
  [[nodiscard]] bool may_keep() const;
  void go_on();
  void advance_to(const Stamped<DeviceState>& sample);
  void note_state();
  [[nodiscard]] Wrench wrench() const;
  [[nodiscard]] bool trusted(Time now) const;

  [[nodiscard]] bool in_each_tick() const { return params_.mode == EngineRolloutParams::Mode::each_tick; }
  /// In each tick, the scene may not have gone through all samples yet: at its begin, or after a gap.
  [[nodiscard]] bool lags() const { return in_each_tick() && advanced_ < track_.count(); }

  const EngineRolloutParams params_;
  const bool torque_;
  EngineMotion motion_;
  CouplingParameters coupling_;  // of the newest state
  RolloutDisplay display_;
  CarriedForce carried_;
  HandleTrack<256> track_;
  std::size_t advanced_ = 0;  // samples that the engine has been through
  ModelIntake intake_;
  RolloutTrust trust_;
  MovedBodies moved_;
  bool failed_ = false;              // a step has, since the state came
  Source source_ = Source::rollout;  // at the last tick
  Time shown_;                       // of the result then
  Wrench held_wrench_;               // within the device's limits
  Wrench result_wrench_;
  std::array<std::int64_t, 3> ticks_{};  // by Source
  std::int64_t failed_steps_ = 0, overruns_ = 0;
};

/// Adds the ports, parameters and metrics of a node with the members `model`, `device`, `segment` and rollout(), its
/// role, and that it may run in the real-time lane. `model`: what that input is; `engine`: who makes the steps.
template <class N>
void declare_engine_rollout(Declare<N>& node, const std::string& model, const std::string& engine) {
  using P = typename N::Params;
  node.realtime_safe()
      .input("model", &N::model, {.doc = model})
      .input("device", &N::device, {.doc = "every sample of the handle", .queue = {QueuePolicy::drop_oldest, 64}})
      .output("segment", &N::segment, "the force over one tick, stamped as the physics result behind it")
      .template real<Duration>(
          "blend_time", &P::blend_time,
          {.doc = "tau, the time constant of each of the two equal poles with which a correction decays",
           .unit = "s",
           .default_value = 0.002,
           .min = 0,
           .max = 1,
           .above_min = true})
      .template integer<std::int32_t>(
          "max_substeps", &P::max_substeps,
          {.doc = "most sub-steps of a tick; if more are due, the force is held until the next result",
           .default_value = 100,
           .min = 1,
           .max = 100000})
      .unneeded(nothing_moves)
      .haptic_rate(&P::rate, {.doc = "ticks per second"})
      .role(Role::interpolation)
      .metric("rollout.ticks", "1", "ticks that went on with the model", Better::neither,
              [](const N& self) { return self.rollout().rolled_ticks(); })
      .metric("rollout.held_ticks", "1", "ticks that held a force", Better::lower,
              [](const N& self) { return self.rollout().held_ticks(); })
      .metric("fallbacks", "1", "ticks that did not go on with the model", Better::lower,
              [](const N& self) { return self.rollout().held_ticks(); })
      .summed()
      .metric("rollout.outdone_ticks", "1", "of them, ticks at which a held result has been nearer to physics",
              Better::lower, [](const N& self) { return self.rollout().outdone_ticks(); })
      .metric("rollout.failed_steps", "1", "steps that " + engine + " could not make", Better::lower,
              [](const N& self) { return self.rollout().failed_steps(); })
      .metric("rollout.overruns", "1", "times that more sub-steps were due than max_substeps", Better::lower,
              [](const N& self) { return self.rollout().overruns(); })
      .metric("rollout.steps", "1", "sub-steps", Better::neither, [](const N& self) { return self.rollout().steps(); })
      .metric("rollout.estimated_error_N", "N", "estimate of the rollout's error at the end, by physics' results",
              Better::lower, [](const N& self) { return self.rollout().trust().error(RolloutTrust::rolled); })
      .metric("rollout.estimated_hold_error_N", "N", "the same of a hold", Better::neither,
              [](const N& self) { return self.rollout().trust().error(RolloutTrust::held_result); })
      .metric("rollout.rejected_models", "1", "models that were not usable", Better::lower,
              [](const N& self) { return self.refusals().refused(); })
      .metric("rollout.rejected_samples", "1", "samples that were not finite, or too late to be used", Better::lower,
              [](const N& self) { return self.rollout().rejected_samples(); })
      .metric("rollout.correction_rms_N", "N", "RMS jump of the model's force where a model arrives", Better::lower,
              [](const N& self) { return self.rollout().correction_rms(); });
}

}  // namespace tactor
