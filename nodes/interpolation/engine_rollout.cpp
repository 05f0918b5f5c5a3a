#include "nodes/interpolation/engine_rollout.hpp"

#include <algorithm>
#include <optional>

#include "nodes/physics/mechanics/coupling_wrench.hpp"

namespace tactor {

namespace {

/// Samples of the handle that one tick goes through at most; of more some are left out.
constexpr std::size_t most_engine_samples = 4;

/// How long and how much worse than a hold the rollout may be; see ErrorEstimate.
TrustOptions with_estimate(TrustOptions options) {
  options.estimate_time = Duration::from_seconds(1);
  options.worse = 1;
  return options;
}

}  // namespace

EngineRollout::EngineRollout(SteppedEngine& engine, double substep, const EngineRolloutParams& params, bool torque)
    : params_(params),
      torque_(torque),
      motion_(engine, substep),
      display_(Duration::from_rate(params.rate), params.blend_time),
      carried_(display_.tick(), torque_),
      trust_(with_estimate(params)) {}

/// The coupling's, on the device.
Wrench EngineRollout::wrench() const {
  return coupling_wrench(coupling_, motion_.tool_and_handle(), torque_);
}

bool EngineRollout::trusted(Time now) const {
  return (in_each_tick() || now - intake_.valid() < trust_.time()) && !failed_;
}

EngineRollout::Source EngineRollout::source_now(Time now) const {
  if (!trusted(now) || lags()) return Source::held;
  return in_each_tick() || trust_.best() == RolloutTrust::rolled ? Source::rollout : Source::result;
}

/// Whether the scene may stay where the rollout has it: a result tells of the tool alone.
bool EngineRollout::may_keep() const {
  if (in_each_tick()) return intake_.running() && !failed_;
  const std::size_t of_tool = motion_.engine().tool_rotates() ? 6 : 3;
  return params_.restart == EngineRolloutParams::Restart::on_disagreement && intake_.running() && !failed_ &&
         source_ == Source::rollout && motion_.engine().numbers().velocity.size() == of_tool;
}

/// Takes the state into use, with the scene as it is or where the state has it; or why not.
RefusalReason EngineRollout::take_state(const EngineState& state, bool keep) {
  if (keep) return motion_.refusal(state);
  // What the handle did between a state and the samples that are known would be guessed.
  if (state.time < track_[track_.first()].stamp.valid && track_.first() > 0) return RefusalReason::late;
  // More bodies than the loop can step without memory of the heap come from a node other than the resimulation.
  constexpr Trees tool_alone = 1;
  const Trees moving = motion_.engine().may_allocate(state.moving) ? tool_alone : state.moving;
  const RefusalReason why = motion_.restart(state, moving);
  if (why == RefusalReason::none) moved_.note(motion_.engine().moving_bodies());
  return why;
}

/// True where a new state has come and is gone on with.
bool EngineRollout::take_model(const Stamped<EngineState>& newest, Time now) {
  if (intake_.is_in_use(newest.stamp) || intake_.was_refused(newest.stamp)) return false;
  // Results that are slow may be trusted for longer than the ones before.
  const Duration most_trusted = std::max(trust_.time(), params_.trust_time_max);
  if (intake_.is_late(newest, now) || now - newest.stamp.valid >= most_trusted) {
    intake_.refuse(newest.stamp, RefusalReason::late);
    return false;
  }
  const bool keep = may_keep() && (in_each_tick() || !trust_.disagrees(newest.stamp.valid, newest.value.p_WT_result));
  if (const RefusalReason why = take_state(newest.value, keep); why != RefusalReason::none) {
    intake_.refuse(newest.stamp, why);
    return false;
  }
  coupling_ = newest.value.coupling;
  if (!keep) {
    failed_ = false;
    held_wrench_ = wrench();
    advanced_ = track_.after(newest.value.time);
    trust_.agree();
  }
  // The whole scene has physics' own law; one of which a part stands has another, which nobody knows.
  const std::optional<double> law_error = motion_.is_whole() ? std::optional(0.0) : std::nullopt;
  trust_.learn(newest.stamp.valid, newest.value.wrench_result.force, law_error, intake_.use(newest.stamp, now));
  result_wrench_ = limited(newest.value.wrench_result, newest.value.coupling);
  return !keep;
}

/// Goes through samples that the engine has not been through yet: in each tick through one after the other, otherwise
/// to the newest.
void EngineRollout::go_on() {
  advanced_ = std::max(advanced_, track_.first());
  const std::size_t due = track_.count() - advanced_;
  const std::size_t steps = std::min(due, most_engine_samples);
  const std::size_t way = in_each_tick() ? steps : due;
  if (way > 0 && motion_.substeps_to(track_[advanced_ + way - 1].stamp.valid) > params_.max_substeps) {
    failed_ = true;
    ++overruns_;
    return;
  }
  for (std::size_t k = 1; k <= steps && !failed_; ++k) advance_to(track_[advanced_ + way * k / steps - 1]);
  advanced_ += way;
}

void EngineRollout::advance_to(const Stamped<DeviceState>& sample) {
  failed_ = !motion_.advance(sample, coupling_);
  if (failed_) {
    ++failed_steps_;
  } else {
    note_state();
  }
}

void EngineRollout::note_state() {
  const PhysicsState state = motion_.tool_and_handle();
  RolloutTrust::Forces forces;
  forces[RolloutTrust::rolled] = wrench().force;
  forces[RolloutTrust::held_result] = forces[RolloutTrust::forecasted] = result_wrench_.force;
  trust_.note(motion_.time(), state.X_WT.p, forces);
}

void EngineRollout::step(Time now, Input<EngineState>& model, Input<DeviceState>& device,
                         Output<ForceSegment>& segment) {
  track_.take(device);
  if (model.latest() == nullptr || track_.count() == 0) return;
  const bool corrected = take_model(*model.latest(), now);
  if (!intake_.running() && !corrected) return;
  if (trusted(now)) go_on();
  const Source source = source_now(now);
  if (source == Source::result) held_wrench_ = result_wrench_;
  ForceState to;
  if (source != Source::rollout) {
    to.value = held_wrench_;
  } else {
    to = carried_.at(now, motion_.time(), motion_.tool_and_handle(), coupling_, motion_.acceleration(),
                     track_.acceleration());
    held_wrench_ = wrench();
  }
  const RolloutDisplay::Aim aim = {
      .force = to,
      .changed = corrected || source != source_ || (source == Source::result && shown_ != intake_.valid()),
      .corrected = corrected,
      .trust_time = trust_.time(),
      // In each tick, the force is of the newest sample, whatever physics does beside.
      .valid = in_each_tick() && source == Source::rollout ? motion_.time() : intake_.valid()};
  if (!display_.show(now, aim, coupling_, intake_, segment)) return;
  source_ = source;
  shown_ = intake_.valid();
  ++ticks_[static_cast<std::size_t>(source)];
}

}  // namespace tactor
