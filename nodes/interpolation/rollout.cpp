#include "nodes/interpolation/rollout.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "nodes/interpolation/forecast_curve.hpp"
#include "nodes/interpolation/not_finite.hpp"
#include "nodes/physics/mechanics/coupling_wrench.hpp"
#include "nodes/physics/mechanics/eigen.hpp"
#include "nodes/physics/mechanics/rollout_parameters.hpp"

namespace tactor {

namespace {

/// Samples of the handle that one tick goes through at most; of more some are left out.
constexpr std::size_t most_steps = 4;

/// N, differences from physics that count as none.
constexpr double estimate_noise = 0.01;

/// When the tool goes to where physics has it, and when another force is displayed.
void declare_restart(Declare<Rollout>& node) {
  using Params = Rollout::Params;
  node.choice<Params::Restart>(
          "restart", &Params::restart,
          {{"always", Params::Restart::always}, {"on_disagreement", Params::Restart::on_disagreement}},
          Params::Restart::on_disagreement,
          "always: each result puts the tool back to where physics has it; on_disagreement: the tool stays where the "
          "rollout has it as long as contacts are found on the surface, nothing else moves, and physics does not keep "
          "disagreeing")
      .real("disagreement", &Params::disagreement,
            {.doc = "physics and the rollout disagree if their tools are farther apart than this",
             .unit = "m",
             .default_value = 5e-4,
             .min = 0,
             .max = 1})
      .real("patience", &Params::patience,
            {.doc = "how long they may disagree in one direction before the tool goes to where physics has it",
             .unit = "s",
             .default_value = 1,
             .min = 0,
             .max = 10});
  node.real("estimate_time", &Params::estimate_time,
            {.doc = "time in which a difference between physics and the displayed force fades to 1/e in the estimate "
                    "of errors",
             .unit = "s",
             .default_value = 1,
             .min = 0.01,
             .max = 100})
      .real("worse", &Params::worse,
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
              [](const Rollout& self) { return self.ticks_[static_cast<std::size_t>(Source::rollout)]; })
      .metric("rollout.jacobian_ticks", "1", "ticks that fell back to the Jacobian", Better::lower,
              [](const Rollout& self) { return self.ticks_[static_cast<std::size_t>(Source::jacobian)]; })
      .metric("rollout.forecast_ticks", "1", "ticks that fell back to the forecast", Better::lower,
              [](const Rollout& self) { return self.ticks_[static_cast<std::size_t>(Source::forecast)]; })
      .metric("rollout.held_ticks", "1", "ticks that held a force", Better::lower,
              [](const Rollout& self) { return self.ticks_[static_cast<std::size_t>(Source::held)]; })
      .metric("fallbacks", "1", "ticks that did not go on with the model", Better::lower,
              [](const Rollout& self) {
                return self.ticks_[static_cast<std::size_t>(Source::jacobian)] +
                       self.ticks_[static_cast<std::size_t>(Source::forecast)] +
                       self.ticks_[static_cast<std::size_t>(Source::held)];
              })
      .summed()
      .metric("rollout.outdone_ticks", "1", "of the fallbacks, ticks at which another force has been nearer to physics",
              Better::lower, &Rollout::outdone_ticks_)
      .metric("rollout.estimated_error_N", "N", "estimate of the rollout's error at the end, by physics' results",
              Better::lower, [](const Rollout& self) { return self.estimate_.error(rolled); })
      .metric("rollout.estimated_hold_error_N", "N", "the same of a hold", Better::neither,
              [](const Rollout& self) { return self.estimate_.error(held_result); })
      .metric("rollout.rejected_models", "1", "models that were not usable", Better::lower,
              [](const Rollout& self) { return self.refused_.refused(); })
      .metric("rollout.rejected_samples", "1", "samples that were not finite, or too late to be used", Better::lower,
              [](const Rollout& self) { return self.track_.rejected(); })
      .metric("rollout.disagreements", "1", "times that the tool went to where physics kept having it", Better::lower,
              &Rollout::disagreements_)
      .left_out_when([](const Rollout::Params& p, const MetricUse&) {
        const bool may_keep =
            p.contacts == SurfaceOptions::From::surface && p.restart == Rollout::Params::Restart::on_disagreement;
        return std::string(may_keep ? "" : "the tool goes back to every result");
      })
      .metric("rollout.anchored_steps", "1", "steps on the contacts that came with the result", Better::lower,
              &Rollout::steps_on_anchors_)
      .left_out_when([](const Rollout::Params& p, const MetricUse&) {
        return std::string(p.contacts == SurfaceOptions::From::surface ? "" : "contacts is anchors: all steps are");
      })
      .metric("rollout.work_mean", "1", "work of the contact query of a step, mean", Better::lower,
              [](const Rollout& self) {
                return self.steps_ > 0 ? static_cast<double>(self.work_) / static_cast<double>(self.steps_) : 0.0;
              })
      .left_out_when(looks_for_none)
      .metric("rollout.work_most", "1", "work of the contact query of a step, most", Better::lower,
              &Rollout::most_work_)
      .left_out_when(looks_for_none)
      .metric("rollout.correction_rms_N", "N", "RMS jump of the model's force where a model arrives", Better::lower,
              [](const Rollout& self) {
                return self.corrections_ > 0 ? std::sqrt(self.correction_sum_ / static_cast<double>(self.corrections_))
                                             : 0.0;
              });
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
             .above_min = true})
      .real("trust_time", &Params::trust_time,
            {.doc = "age of a physics result beyond which its model is no longer used. Three times the longest of the "
                    "last 16 intervals between results counts instead if that is more",
             .unit = "s",
             .default_value = 0.25,
             .min = 0,
             .max = 10})
      .real("trust_time_max", &Params::trust_time_max,
            {.doc = "upper limit of trust_time when results are slow; longer intervals do not count",
             .unit = "s",
             .default_value = 1,
             .min = 0,
             .max = 10})
      .real("trust_distance", &Params::trust_distance,
            {.doc = "largest distance at which a model is trusted: of the tool from the anchors if it is on them, and "
                    "from its place in the result if something deforms; of the handle from where a step failed. A tool "
                    "that is farther than this from where physics has it goes there",
             .unit = "m",
             .default_value = 0.02,
             .min = 0,
             .max = 10})
      .unneeded(nothing_moves)
      .haptic_rate(&Params::rate, {.doc = "ticks per second"});
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
      tick_(Duration::from_rate(params.rate)),
      surface_(surface_contacts(params, context)),
      soft_(patch_contacts(params, context)),
      rollout_(rollout_model("interpolation.rollout", params, context), surface_.get(), soft_.get()),
      carried_(tick_, torque_),
      blended_(tick_, params.blend_time),
      trust_(params.trust_time),
      estimate_({.memory = params.estimate_time, .worse = params.worse, .noise = estimate_noise, .results = 8}) {}

/// Whether the tool stays where the rollout has it though a result has come.
bool Rollout::keeps_tool() const {
  return params_.restart == Params::Restart::on_disagreement && running_ && !failed_ && source_ == Source::rollout &&
         rollout_.on_surface() && rollout_.model().bodies.count == 1 && soft_ == nullptr;
}

/// Where the rollout had the tool at a sample; null where it was not there or it is too long ago.
const Rollout::Then* Rollout::known_at(Time time) const {
  const std::span noted = std::span(path_).first(std::min(noted_, path_.size()));
  const auto then = std::find_if(noted.begin(), noted.end(), [&](const Then& t) { return t.time == time; });
  return then == noted.end() ? nullptr : &*then;
}

/// Whether physics has its tool farther away than is trusted, or has had it elsewhere, in about the same direction, for
/// longer than the patience.
bool Rollout::disagrees(const Stamped<LocalModel>& result) {
  const Then* then = known_at(result.stamp.valid);
  if (then == nullptr) return false;
  const Vec3 apart = result.value.p_WT_result - then->p_WT;
  if (!(norm(apart) < params_.trust_distance)) {
    ++disagreements_;
    return true;
  }
  const bool beyond = norm(apart) > params_.disagreement;
  if (!beyond || !apart_now_ || dot(apart, apart_) < 0.5 * dot(apart_, apart_)) {
    apart_now_ = beyond;
    apart_ = apart;
    apart_since_ = result.stamp.valid;
    return false;
  }
  if (result.stamp.valid - apart_since_ < params_.patience) return false;
  ++disagreements_;
  return true;
}

/// True where a new model has come and is gone on with.
bool Rollout::take_model(Time now) {
  const Stamped<LocalModel>& newest = *model.latest();
  if (running_ && newest.stamp.sequence == used_.sequence) return false;
  // The bodies may be brought on to a sample that has not arrived here yet, but not to one beyond now.
  const bool older = running_ && newest.stamp.valid < used_.valid;
  const bool judged = !older && newest.value.time <= now && newest.stamp.sequence != rejected_;
  const bool keep = keeps_tool() && !(judged && disagrees(newest));
  if (older || newest.value.time > now || !(keep ? rollout_.learn(newest.value) : rollout_.restart(newest.value))) {
    if (newest.stamp.sequence != rejected_) count_refused(newest.value, older || newest.value.time > now);
    rejected_ = newest.stamp.sequence;
    return false;
  }
  refused_.count(RefusalReason::none);
  // The age of the first one is what physics took to make it.
  note_interval(running_ ? newest.stamp.valid - used_.valid : now - newest.stamp.valid);
  if (const Then* then = known_at(newest.stamp.valid)) {
    estimate_.take(newest.stamp.valid, newest.value.wrench_result.force, then->forces, newest.value.law_error);
  }
  held_result_ = limited(newest.value.wrench_result, newest.value.coupling);
  used_ = newest.stamp;
  if (keep) return false;
  apart_now_ = false;
  failed_ = false;
  held_ = coupling_wrench(newest.value.coupling, rollout_.state(), torque_);
  advanced_ = track_.first();
  while (advanced_ < track_.count() && track_[advanced_].stamp.valid <= newest.value.time) ++advanced_;
  return true;
}

void Rollout::count_refused(const LocalModel& newest, bool late) {
  const RefusalReason why = late ? RefusalReason::late : rollout_.refusal(newest);
  if (why == RefusalReason::too_many) {
    refused_.count_too_many(newest.contacts.count, LocalContacts::capacity);
  } else {
    // What the rollout would accept by itself does not go with the patch that it steps.
    refused_.count(why == RefusalReason::none ? RefusalReason::another_scene : why);
  }
}

/// Trusts slow physics for longer, as long as it comes.
void Rollout::note_interval(Duration interval) {
  // An interval beyond trust_time_max is a failure, and not slow physics.
  if (!(interval < params_.trust_time_max)) return;
  intervals_[interval_count_++ % intervals_.size()] = interval;
  const Duration longest = *std::max_element(intervals_.begin(), intervals_.end());
  trust_ = std::max(params_.trust_time, std::min(Duration{3 * longest.ns}, params_.trust_time_max));
}

/// Goes through the samples that the rollout has not been through yet.
void Rollout::go_on() {
  const std::size_t due = track_.count() - advanced_;
  const std::size_t steps = std::min(due, most_steps);
  for (std::size_t k = 1; k <= steps && !failed_; ++k) {
    const std::size_t to = advanced_ + due * k / steps;
    failed_ = !rollout_.advance(track_[to - 1]);
    note_then();
    ++steps_;
    if (!rollout_.on_surface()) ++steps_on_anchors_;
    const int work = surface_ == nullptr ? 0 : surface_->work();
    work_ += work;
    most_work_ = std::max<std::int64_t>(most_work_, work);
  }
  advanced_ = track_.count();
}

/// Keeps what a result that is still to come will be compared with.
void Rollout::note_then() {
  const LocalModel& local = rollout_.model();
  Then& then = path_[noted_++ % path_.size()];
  then.time = local.time;
  then.p_WT = local.bodies.X_WB[0].p;
  then.forces[rolled] = coupling_wrench(local.coupling, rollout_.state(), torque_).force;
  then.forces[held_result] = held_result_.force;
  then.forces[forecasted] = knows_forecast(local.time)
                                ? ForecastCurve(*forecast.latest(), CurveShape::linear).at(local.time).value.force
                                : held_result_.force;
}

bool Rollout::knows_forecast(Time now) const {
  return forecast.connected() && forecast.latest() != nullptr && !segment_if_not_finite(now, forecast.latest()->value);
}

/// True once for each forecast that is displayed.
bool Rollout::is_new_forecast() {
  const std::uint64_t sequence = forecast.latest()->stamp.sequence;
  return std::exchange(forecast_shown_, sequence) != sequence;
}

bool Rollout::trusted(Time now) const {
  return now - used_.valid < trust_ && rollout_.distance_from_known() < params_.trust_distance;
}

Rollout::Source Rollout::choose(Time now) const {
  if (trusted(now)) {
    if (estimate_.best() == forecasted && knows_forecast(now)) return Source::forecast;
    if (estimate_.best() != rolled) return Source::held;
    if (!failed_) return Source::rollout;
    if (is_near_anchor()) return Source::jacobian;
  }
  return knows_forecast(now) && touching_ ? Source::forecast : Source::held;
}

/// Whether the rollout's force was displayed until its step failed, with the handle about where it is now.
bool Rollout::is_near_anchor() const {
  const bool goes_on = source_ == Source::rollout || source_ == Source::jacobian;
  return goes_on && ticks_[static_cast<std::size_t>(Source::rollout)] > 0 &&
         norm(track_.newest().value.X_WD.p - anchor_X_WD_.p) < params_.trust_distance;
}

ForceState Rollout::of_jacobian() const {
  const DeviceState& handle = track_.newest().value;
  const auto change = [this](const Vec3& translation, const Vec3& turn) {
    Eigen::Matrix<double, 6, 1> way;
    way << eigen(translation), eigen(turn);
    const Eigen::Matrix<double, 6, 1> by = jacobian_ * way;
    return Wrench{plain(by.head<3>()), torque_ ? plain(by.tail<3>()) : Vec3{}};
  };
  const Vec3 turn = to_rotation_vector(handle.X_WD.R * inverse(anchor_X_WD_.R));
  ForceState state{
      anchor_.value + change(handle.X_WD.p - anchor_X_WD_.p, turn), change(handle.V_WD.v, handle.V_WD.w), {}};
  // A contact that is left does not pull.
  const Vec3& before = anchor_.value.force;
  const double along = dot(state.value.force, before), square = dot(before, before);
  if (along < 0 && square > 0) {
    state.value.force -= (along / square) * before;
    state.rate.force -= (dot(state.rate.force, before) / square) * before;
  }
  state.value = limited(state.value, rollout_.model().coupling);
  return state;
}

ForceState Rollout::aim(Source source, Time now) {
  switch (source) {
    case Source::rollout: {
      const ForceState state = carried_.at(now, rollout_, track_.acceleration());
      if (!is_finite(state.value)) return state;
      anchor_ = state;
      anchor_X_WD_ = track_.newest().value.X_WD;
      held_ = coupling_wrench(rollout_.model().coupling, rollout_.state(), torque_);
      touching_ = rollout_.state().contacts > 0;
      return state;
    }
    case Source::jacobian: {
      if (source_ != Source::jacobian) jacobian_ = rollout_.jacobian();
      const ForceState state = of_jacobian();
      held_ = state.value;
      return state;
    }
    case Source::forecast: {
      ForceState state = ForecastCurve(*forecast.latest(), CurveShape::linear).at(now);
      state.value = limited(state.value, rollout_.model().coupling);
      if (!torque_) state.value.torque = state.rate.torque = {};
      return state;
    }
    case Source::held:
      break;
  }
  return {estimate_.best() == rolled ? held_ : held_result_, {}, {}};
}

void Rollout::step(StepContext& context) {
  track_.take(device);
  if (model.latest() == nullptr || track_.count() == 0) return;
  const Time now = context.now();
  const bool corrected = take_model(now);
  if (!running_ && !corrected) return;
  go_on();
  const Source source = choose(now);
  ForceState to = aim(source, now);
  if (const auto fault = segment_if_not_finite(now, {to.value, to.rate})) return segment.send(used_.valid, *fault);
  // A sample that is finite and yet absurd would else be blended out for long.
  const CouplingParameters& coupling = rollout_.model().coupling;
  to.rate = limited(to.rate, coupling, 1 / tick_.seconds());
  const bool other = corrected || source != source_ || (source == Source::forecast && is_new_forecast());
  ForceSegment shown = blended_.go_on(now, to, one_tick_later(to, tick_, coupling), other);
  // Zero would say nothing.
  shown.trust_time = std::max(trust_, Duration{1});
  if (running_ && corrected) {
    ++corrections_;
    const Vec3& jump = blended_.difference().value.force;
    correction_sum_ += dot(jump, jump);
  }
  source_ = source;
  running_ = true;
  if (source != Source::rollout && !failed_ && trusted(now)) ++outdone_ticks_;
  ++ticks_[static_cast<std::size_t>(source)];
  segment.send(used_.valid, shown);
}

}  // namespace tactor
