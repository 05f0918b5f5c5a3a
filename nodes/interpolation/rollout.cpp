#include "nodes/interpolation/rollout.hpp"

#include <algorithm>

#include "nodes/interpolation/declare_trust.hpp"
#include "nodes/interpolation/forecast_curve.hpp"
#include "nodes/interpolation/not_finite.hpp"
#include "nodes/physics/mechanics/coupling_wrench.hpp"
#include "nodes/physics/mechanics/rollout_parameters.hpp"

namespace tactor {

namespace {

/// Samples of the handle that one tick goes through at most; of more some are left out.
constexpr std::size_t most_steps = 4;

/// When the tool goes to where physics has it, and when another force is displayed.
void declare_restart(Declare<Rollout>& node) {
  using Params = Rollout::Params;
  node.choice<Params::Restart>(
      "restart", &Params::restart,
      {{"always", Params::Restart::always}, {"on_disagreement", Params::Restart::on_disagreement}},
      Params::Restart::on_disagreement,
      "always: each result puts the tool back to where physics has it; on_disagreement: the tool stays where the "
      "rollout has it as long as contacts are found on the surface, nothing else moves, and physics does not keep "
      "disagreeing");
  declare_disagreement(node, "tool");
  node.real<Duration>(
          "estimate_time", &Params::estimate_time,
          {.doc = "time in which a difference between physics and the displayed force fades to 1/e in the estimate "
                  "of errors",
           .unit = "s",
           .default_value = 1,
           .min = 0.01,
           .max = 100})
      .real<double>(
          "worse", &Params::worse,
          {.doc = "the hold or the `forecast` is displayed if the rollout's estimated error is more than this many "
                  "times theirs",
           .default_value = 1.2,
           .min = 1,
           .max = 1e6});
}

}  // namespace

void Rollout::declare_metrics(Declare<Rollout>& node) {
  const auto looks_for_none = [](const Rollout::Params& p, const MetricUse&) {
    const bool looks = p.contacts == SurfaceOptions::From::surface;
    return std::string(looks ? "" : "contacts is anchors: no contacts are searched");
  };
  node.metric("rollout.ticks", "1", "ticks that went on with the model", Better::neither,
              [](const Rollout& self) { return self.ticks(Source::rollout); })
      .metric("rollout.jacobian_ticks", "1", "ticks that fell back to the Jacobian", Better::lower,
              [](const Rollout& self) { return self.ticks(Source::jacobian); })
      .metric("rollout.forecast_ticks", "1", "ticks that fell back to the forecast", Better::lower,
              [](const Rollout& self) { return self.ticks(Source::forecast); })
      .metric("rollout.held_ticks", "1", "ticks that held a force", Better::lower,
              [](const Rollout& self) { return self.ticks(Source::held); })
      .metric("fallbacks", "1", "ticks that did not go on with the model", Better::lower,
              [](const Rollout& self) {
                return self.ticks(Source::jacobian) + self.ticks(Source::forecast) + self.ticks(Source::held);
              })
      .summed()
      .metric("rollout.outdone_ticks", "1", "of the fallbacks, ticks at which another force has been nearer to physics",
              Better::lower, &Rollout::outdone_ticks_)
      .metric("rollout.estimated_error_N", "N", "estimate of the rollout's error at the end, by physics' results",
              Better::lower, [](const Rollout& self) { return self.trust_.error(RolloutTrust::rolled); })
      .metric("rollout.estimated_hold_error_N", "N", "the same of a hold", Better::neither,
              [](const Rollout& self) { return self.trust_.error(RolloutTrust::held_result); })
      .metric("rollout.rejected_models", "1", "models that were not usable", Better::lower,
              [](const Rollout& self) { return self.intake_.refusals().refused(); })
      .metric("rollout.rejected_samples", "1", "samples that were not finite, or too late to be used", Better::lower,
              [](const Rollout& self) { return self.track_.rejected(); })
      .metric("rollout.disagreements", "1", "times that the tool went to where physics kept having it", Better::lower,
              [](const Rollout& self) { return self.trust_.disagreements(); })
      .left_out_when([](const Rollout::Params& p, const MetricUse&) {
        const bool may_keep =
            p.contacts == SurfaceOptions::From::surface && p.restart == Rollout::Params::Restart::on_disagreement;
        return std::string(may_keep ? "" : "the tool goes back to every result");
      })
      .metric("rollout.anchored_steps", "1", "steps on the contacts that came with the result", Better::lower,
              [](const Rollout& self) { return self.scene_.steps_on_anchors(); })
      .left_out_when([](const Rollout::Params& p, const MetricUse&) {
        return std::string(p.contacts == SurfaceOptions::From::surface ? "" : "contacts is anchors: all steps are");
      })
      .metric("rollout.work_mean", "1", "work of the contact query of a step, mean", Better::lower,
              [](const Rollout& self) { return self.scene_.work_mean(); })
      .left_out_when(looks_for_none)
      .metric("rollout.work_most", "1", "work of the contact query of a step, most", Better::lower,
              [](const Rollout& self) { return self.scene_.work_most(); })
      .left_out_when(looks_for_none)
      .metric("rollout.correction_rms_N", "N", "RMS jump of the model's force where a model arrives", Better::lower,
              [](const Rollout& self) { return self.display_.correction_rms(); });
}

NodeInfo Rollout::declare() {
  Declare<Rollout> node("interpolation.rollout", "Continues a local model through each sample of the handle.");
  node.details(
          "It is the display side of prediction.local: the step of the dynamics once per tick, on the contacts of the "
          "newest model. The node displays the coupling's wrench and its rate, so the tick until the device shows it "
          "adds no delay. When a model arrives, the displayed force stays as it is. The difference decays as tau^2 e'' "
          "+ 2 tau e' + e = 0, from a rate between 0 and -e / tau, so it neither grows nor overshoots. A result is "
          "trusted until it is older than `trust_time` and than three intervals between results. On anchors, the tool "
          "must also be within `trust_distance` of them. If something deforms, the tool must be within that distance "
          "of its place in the result. If a step fails and the result is trusted, the force continues by the Jacobian "
          "of the balance of springs. Otherwise, the node displays the forecast of `forecast` if the tool touched "
          "something, or else holds a force. The report counts each of these cases. The segments tell the device for "
          "how long a result is trusted. Its gate fades the force out when that time has passed, or its own "
          "`stale_after`.")
      .realtime_safe()
      .input("model", &Rollout::model, {.doc = "the local model to continue from"})
      .input("device", &Rollout::device, {.doc = "every sample of the handle", .queue = {QueuePolicy::drop_oldest, 64}})
      .input("forecast", &Rollout::forecast, {.doc = "the forecast to fall back to", .required = false})
      .output("segment", &Rollout::segment, "the force over one tick, stamped as the physics result behind it")
      .real("blend_time", &Params::blend_time,
            {.doc = "tau, the time constant of each of the two equal poles with which a correction decays",
             .unit = "s",
             .default_value = 0.002,
             .min = 0,
             .max = 1,
             .above_min = true});
  declare_trust(node, "its model is no longer used",
                "largest distance at which a model is trusted: of the tool from the anchors if it is on them, and from "
                "its place in the result if something deforms; of the handle from where a step failed. A tool that is "
                "farther than this from where physics has it goes there");
  node.unneeded(nothing_moves).haptic_rate(&Params::rate, {.doc = "ticks per second"});
  declare_rollout(node);
  declare_surface(node, 2000);
  declare_patch_contacts(node);
  declare_restart(node);
  node.role(Role::interpolation);
  declare_metrics(node);
  return node.info();
}

Rollout::Rollout(const Params& params, const NodeContext& context)
    : params_(params),
      torque_(context.torque),
      display_(Duration::from_rate(params.rate), params.blend_time),
      scene_{surface_contacts(params, context), patch_contacts(params, context),
             rollout_model("interpolation.rollout", params, context)},
      carried_(display_.tick(), torque_),
      trust_(params),
      fallback_(torque_) {}

/// Whether the tool stays where the rollout has it though a result has come.
bool Rollout::keeps_tool() const {
  const LocalRollout& rollout = scene_.rollout();
  return params_.restart == Params::Restart::on_disagreement && intake_.running() && !failed_ &&
         source_ == Source::rollout && rollout.on_surface() && rollout.model().bodies.count == 1 && !scene_.deforms();
}

/// True where a new model has come and is gone on with.
bool Rollout::take_model(Time now) {
  const Stamped<LocalModel>& newest = *model.latest();
  if (intake_.is_in_use(newest.stamp)) return false;
  LocalRollout& rollout = scene_.rollout();
  const bool late = intake_.is_late(newest, now), refused = intake_.was_refused(newest.stamp);
  const bool keep = keeps_tool() && (late || refused || !trust_.disagrees(newest));
  if (late || !(keep ? rollout.learn(newest.value) : rollout.restart(newest.value))) {
    if (!refused) intake_.refuse(newest, late ? RefusalReason::late : rollout.refusal(newest.value));
    return false;
  }
  trust_.learn(newest, intake_.use(newest.stamp, now));
  fallback_.take_result(newest.value);
  if (keep) return false;
  trust_.agree();
  failed_ = false;
  fallback_.begin(rollout);
  advanced_ = track_.after(newest.value.time);
  return true;
}

/// Goes through the samples that the rollout has not been through yet.
void Rollout::go_on() {
  const std::size_t due = track_.count() - advanced_;
  const std::size_t steps = std::min(due, most_steps);
  for (std::size_t k = 1; k <= steps && !failed_; ++k) {
    failed_ = !scene_.advance(track_[advanced_ + due * k / steps - 1]);
    note_state();
  }
  advanced_ = track_.count();
}

void Rollout::note_state() {
  const LocalModel& local = scene_.rollout().model();
  RolloutTrust::Forces forces;
  forces[RolloutTrust::rolled] = coupling_wrench(local.coupling, scene_.rollout().state(), torque_).force;
  forces[RolloutTrust::held_result] = fallback_.held_result().force;
  forces[RolloutTrust::forecasted] =
      knows_forecast(local.time) ? ForecastCurve(*forecast.latest(), CurveShape::linear).at(local.time).value.force
                                 : fallback_.held_result().force;
  trust_.note(local.time, local.bodies.X_WB[0].p, forces);
}

bool Rollout::knows_forecast(Time now) const {
  return forecast.connected() && forecast.latest() != nullptr && !segment_if_not_finite(now, forecast.latest()->value);
}

bool Rollout::trusted(Time now) const {
  return now - intake_.valid() < trust_.time() && scene_.rollout().distance_from_known() < params_.trust_distance;
}

Rollout::Source Rollout::choose(Time now) const {
  if (trusted(now)) {
    if (trust_.best() == RolloutTrust::forecasted && knows_forecast(now)) return Source::forecast;
    if (trust_.best() != RolloutTrust::rolled) return Source::held;
    if (!failed_) return Source::rollout;
    if (is_near_kept()) return Source::jacobian;
  }
  return knows_forecast(now) && fallback_.touching() ? Source::forecast : Source::held;
}

/// Whether the rollout's force was displayed until its step failed, with the handle about where it is now.
bool Rollout::is_near_kept() const {
  const bool goes_on = source_ == Source::rollout || source_ == Source::jacobian;
  return goes_on && ticks(Source::rollout) > 0 && fallback_.distance(track_.newest().value) < params_.trust_distance;
}

ForceState Rollout::aim(Source source, Time now) {
  LocalRollout& rollout = scene_.rollout();
  const DeviceState& handle = track_.newest().value;
  switch (source) {
    case Source::rollout: {
      const ForceState state = carried_.at(now, rollout, track_.acceleration());
      if (is_finite(state.value)) fallback_.keep(state, handle.X_WD, rollout);
      return state;
    }
    case Source::jacobian:
      if (source_ != Source::jacobian) fallback_.set_jacobian(rollout.jacobian());
      return fallback_.by_jacobian(handle, rollout.model().coupling);
    case Source::forecast:
      return fallback_.of_forecast(*forecast.latest(), now, rollout.model().coupling);
    case Source::held:
      break;
  }
  return {trust_.best() == RolloutTrust::rolled ? fallback_.held() : fallback_.held_result(), {}, {}};
}

void Rollout::step(StepContext& context) {
  track_.take(device);
  if (model.latest() == nullptr || track_.count() == 0) return;
  const Time now = context.now();
  const bool corrected = take_model(now);
  if (!intake_.running() && !corrected) return;
  go_on();
  const Source source = choose(now);
  const ForceState to = aim(source, now);
  const bool other =
      corrected || source != source_ || (source == Source::forecast && fallback_.is_new(*forecast.latest()));
  if (!display_.show(now,
                     {.force = to,
                      .changed = other,
                      .corrected = corrected,
                      .trust_time = trust_.time(),
                      .valid = intake_.valid()},
                     scene_.rollout().model().coupling, intake_, segment)) {
    return;
  }
  source_ = source;
  if (source != Source::rollout && !failed_ && trusted(now)) ++outdone_ticks_;
  ++ticks_[static_cast<std::size_t>(source)];
}

}  // namespace tactor
