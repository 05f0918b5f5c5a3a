// interpolation.rollout: continues a local model tick by tick.
#pragma once

#include <array>

#include "framework/core/messages.hpp"
#include "framework/core/refusals.hpp"
#include "framework/node/declare.hpp"
#include "nodes/interpolation/blended_force.hpp"
#include "nodes/interpolation/model_intake.hpp"
#include "nodes/interpolation/rollout_display.hpp"
#include "nodes/interpolation/rollout_fallback.hpp"
#include "nodes/interpolation/rollout_trust.hpp"
#include "nodes/interpolation/stepped_scene.hpp"
#include "nodes/physics/contact/patch_contacts.hpp"
#include "nodes/physics/contact/surface_contacts.hpp"
#include "nodes/physics/mechanics/handle_track.hpp"
#include "nodes/physics/mechanics/local_model.hpp"

namespace tactor {

/// Moves the bodies of the newest model through each sample of the handle and displays the coupling's wrench,
/// F(t) = F + F' (t - t_s) from the sample at t_s on, F' from the velocities and accelerations of handle and tool, so
/// that the tick that passes until the device displays it is not shown late. Where a model arrives the displayed
/// force stays as it is, and the difference decays with two equal poles.
///
/// The force displayed if the rollout cannot be trusted, in this order, each counted:
///   1. the Jacobian, if a step failed and the result is trusted: the last force and its change with the handle's
///      place, up to `trust_distance` away, as long as it does not pull;
///   2. the forecast of `forecast` for now, if the tool last touched something;
///   3. the force of the newest model or of the last trusted tick, whichever is newer, held.
/// A model is trusted if its result is younger than `trust_time`, or than three times the longest recent interval
/// between results, up to `trust_time_max`. On anchors, its tool must also be within `trust_distance` of them. Segments
/// state that time, so the device's gate fades the force out when it has passed. All changes are blended like
/// corrections, so the last one is a hold with a low-pass.
///
/// A rollout that is trusted is still compared with physics: each result tells how far the rollout, the forecast and a
/// hold were from it at its stamp (see RolloutTrust). Where another has been nearer because physics has another law of
/// contact, it is displayed, and counted.
class Rollout final : public Node, public Refusing {
 public:
  struct Params : SurfaceOptions, SoftContactOptions, TrustOptions {
    Duration blend_time;
    std::int32_t iterations = 0;
    double stick_velocity = 0;  // m/s
    Integrator integrator = Integrator::implicit_euler;
    double rate = 0;
    enum class Restart { always, on_disagreement };
    Restart restart = Restart::on_disagreement;
  };
  Rollout(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  void step(StepContext& context) override;
  [[nodiscard]] const Refusals& refusals() const override { return intake_.refusals(); }

  Input<LocalModel> model;
  Input<DeviceState> device;
  Input<Forecast> forecast;
  Output<ForceSegment> segment;

 private:
  enum class Source : std::uint8_t { rollout, jacobian, forecast, held };

  static void declare_metrics(Declare<Rollout>& node);
  bool take_model(Time now);
  [[nodiscard]] bool keeps_tool() const;
  void go_on();
  void note_state();
  [[nodiscard]] bool knows_forecast(Time now) const;
  [[nodiscard]] bool is_near_kept() const;
  [[nodiscard]] bool trusted(Time now) const;
  [[nodiscard]] Source choose(Time now) const;
  [[nodiscard]] ForceState aim(Source source, Time now);
  [[nodiscard]] std::int64_t ticks(Source source) const { return ticks_[static_cast<std::size_t>(source)]; }

  Params params_;
  bool torque_;
  RolloutDisplay display_;
  SteppedScene scene_;
  CarriedForce carried_;
  HandleTrack<256> track_;
  std::size_t advanced_ = 0;  // samples that the rollout has been through
  ModelIntake intake_;
  RolloutTrust trust_;
  RolloutFallback fallback_;
  bool failed_ = false;  // a step has, since the model came
  Source source_ = Source::rollout;
  std::array<std::int64_t, 4> ticks_{};  // by source
  std::int64_t outdone_ticks_ = 0;
};

}  // namespace tactor
