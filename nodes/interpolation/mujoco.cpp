#include "nodes/interpolation/mujoco.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "framework/core/clock.hpp"
#include "framework/core/value_error.hpp"
#include "nodes/interpolation/declare_trust.hpp"
#include "nodes/interpolation/not_finite.hpp"
#include "nodes/physics/mechanics/coupling_wrench.hpp"
#include "nodes/physics/mechanics/scene_model.hpp"

namespace tactor {

namespace {

/// Samples of the handle that one tick goes through at most; of more some are left out.
constexpr std::size_t most_samples = 4;

constexpr const char* no_results = "mode is each_tick: the scene needs no result but the first";

/// Ticks that are measured before a run, and the share of a tick that all but one in a hundred of them may take.
constexpr int measured_ticks = 300;
constexpr double most_of_tick = 0.5;

/// Whether results of physics start the scene again.
void declare_mode(Declare<MujocoRollout>& node) {
  using Params = MujocoRollout::Params;
  node.choice<Params::Mode>(
      "mode", &Params::mode, {{"rollout", Params::Mode::rollout}, {"each_tick", Params::Mode::each_tick}},
      Params::Mode::rollout,
      "rollout: from one result of physics to the next, with the bodies that the result says. each_tick: all of the "
      "scene, from the first result on, so nothing is predicted; for models of which a tick takes less than half of "
      "its time, which is measured before a run by the machine's clock");
}

/// When the scene goes to where physics has it, and how long a state is trusted.
void declare_restart_of_scene(Declare<MujocoRollout>& node) {
  using Params = MujocoRollout::Params;
  node.choice<Params::Restart>(
      "restart", &Params::restart,
      {{"always", Params::Restart::always}, {"on_disagreement", Params::Restart::on_disagreement}},
      Params::Restart::always,
      "always: each result puts the scene back to where physics has it; on_disagreement: the scene stays where the "
      "rollout has it as long as nothing else moves and physics does not keep having the tool elsewhere");
  declare_trust(node, "it is no longer continued",
                "a tool that is farther than this from where physics has it goes there at once");
  declare_disagreement(node, "scene");
  node.unread_when({"trust_distance", "disagreement", "patience"}, [](const Params& params, const ParamUse&) {
    if (params.mode == Params::Mode::each_tick) return std::string(no_results);
    const bool keeps = params.restart == Params::Restart::on_disagreement;
    return std::string(keeps ? "" : "restart is always: the scene goes back to every result");
  });
  node.unread_when({"restart", "trust_time", "trust_time_max"}, [](const Params& params, const ParamUse&) {
    return std::string(params.mode == Params::Mode::each_tick ? no_results : "");
  });
}

}  // namespace

void MujocoRollout::declare_metrics(Declare<MujocoRollout>& node) {
  node.metric("rollout.ticks", "1", "ticks that went on with the model", Better::neither, &MujocoRollout::rolled_ticks_)
      .metric("rollout.held_ticks", "1", "ticks that held a force", Better::lower, &MujocoRollout::held_ticks_)
      .metric("fallbacks", "1", "ticks that did not go on with the model", Better::lower, &MujocoRollout::held_ticks_)
      .summed()
      .metric("rollout.failed_steps", "1", "steps that MuJoCo could not make", Better::lower,
              &MujocoRollout::failed_steps_)
      .metric("rollout.overruns", "1", "times that more sub-steps were due than max_substeps", Better::lower,
              &MujocoRollout::overruns_)
      .metric("rollout.steps", "1", "sub-steps", Better::neither,
              [](const MujocoRollout& self) { return self.motion_.steps(); })
      .metric("rollout.moving_bodies", "1",
              "bodies that the rollout moved, each with what hangs on it; the others stood. Median of the results",
              Better::neither, [](const MujocoRollout& self) { return self.moved_.quantile(0.5); })
      .metric("rollout.least_moving_bodies", "1", "the same, the least of all results", Better::neither,
              [](const MujocoRollout& self) { return self.moved_.quantile(0); })
      .metric("rollout.most_moving_bodies", "1", "the same, the most of all results", Better::neither,
              [](const MujocoRollout& self) { return self.moved_.quantile(1); })
      .metric("rollout.estimated_error_N", "N", "estimate of the rollout's error at the end, by physics' results",
              Better::lower, [](const MujocoRollout& self) { return self.trust_.error(RolloutTrust::rolled); })
      .metric("rollout.estimated_hold_error_N", "N", "the same of a hold", Better::neither,
              [](const MujocoRollout& self) { return self.trust_.error(RolloutTrust::held_result); })
      .metric("rollout.rejected_models", "1", "models that were not usable", Better::lower,
              [](const MujocoRollout& self) { return self.intake_.refusals().refused(); })
      .metric("rollout.rejected_samples", "1", "samples that were not finite, or too late to be used", Better::lower,
              [](const MujocoRollout& self) { return self.track_.rejected(); })
      .metric("rollout.disagreements", "1", "times that the tool went to where physics kept having it", Better::lower,
              [](const MujocoRollout& self) { return self.trust_.disagreements(); })
      .left_out_when([](const Params& p, const MetricUse&) {
        return std::string(p.restart == Params::Restart::always ? "the scene goes back to every result" : "");
      })
      .metric("rollout.correction_rms_N", "N", "RMS jump of the model's force where a model arrives", Better::lower,
              [](const MujocoRollout& self) { return self.blended_.correction_rms(); });
}

NodeInfo MujocoRollout::declare() {
  Declare<MujocoRollout> node("interpolation.mujoco", "Continues MuJoCo's scene through each sample of the handle.");
  node.details(
          "It is the display side of prediction.mujoco. The node has a scene of MuJoCo of its own. It puts it into the "
          "newest state and makes one or more sub-steps per tick, with the bodies that the state says; the others "
          "stand "
          "where it has them. It displays the "
          "coupling's wrench and its rate, so the tick until the device shows it adds no delay. When a state arrives, "
          "the displayed force stays as it is. The difference decays as tau^2 e'' + 2 tau e' + e = 0, from a rate "
          "between 0 and -e / tau, so it neither grows nor overshoots. A result is trusted until it is older than "
          "`trust_time` and than three intervals between results; then, or if a step fails, the last force is held. "
          "The same holds if a tick would need more than `max_substeps`, after a gap in the samples of the handle. "
          "The segments tell the device for how long a result is trusted.\nA step takes the time that MuJoCo takes, "
          "for which nothing gives a bound: measure it on your scene before you put the node into the real-time lane. "
          "With `mode: each_tick` it goes on from the first result with all bodies and never goes back. Then nothing "
          "is "
          "predicted, and physics is stepped for the report alone.\nMuJoCo allocates memory in the steps of large "
          "models. The node refuses a model that is too large even where the tool alone moves.")
      .realtime_safe()
      .input("model", &MujocoRollout::model, {.doc = "the state to continue from, as prediction.mujoco sends it"})
      .input("device", &MujocoRollout::device,
             {.doc = "every sample of the handle", .queue = {QueuePolicy::drop_oldest, 64}})
      .output("segment", &MujocoRollout::segment, "the force over one tick, stamped as the physics result behind it")
      .real("blend_time", &Params::blend_time,
            {.doc = "tau, the time constant of each of the two equal poles with which a correction decays",
             .unit = "s",
             .default_value = 0.002,
             .min = 0,
             .max = 1,
             .above_min = true})
      .integer("max_substeps", &Params::max_substeps,
               {.doc = "most sub-steps of a tick; if more are due, the force is held until the next result",
                .default_value = 100,
                .min = 1,
                .max = 100000})
      .unneeded(nothing_moves)
      .haptic_rate(&Params::rate, {.doc = "ticks per second"})
      .role(Role::interpolation);
  declare_engine_model(node, false, 2.5e-4);
  node.as_in("model", Role::dynamics).as_in("tool", Role::dynamics).as_in("keyframe", Role::dynamics);
  declare_mode(node);
  declare_restart_of_scene(node);
  declare_metrics(node);
  return node.coarser("substep", {5e-4, 1e-3}).info();
}

MujocoRollout::MujocoRollout(const Params& params, const NodeContext& context)
    : name_(context.name),
      params_(params),
      torque_(context.torque),
      tick_(Duration::from_rate(params.rate)),
      motion_(load_engine("interpolation.mujoco", params, context, params.mode == Params::Mode::rollout),
              params.substep),
      all_bodies_(motion_.engine().moving_bodies()),
      carried_(tick_, torque_),
      blended_(tick_, params.blend_time),
      trust_([&params] {
        TrustOptions options = params;
        // The rollout has physics' own law, so it is compared with physics for the report alone.
        options.estimate_time = Duration::from_seconds(1);
        options.worse = 1;
        return options;
      }()) {
  constexpr Trees tool_alone = 1;
  if (const std::string why = motion_.engine().allocates(tool_alone); !why.empty()) {
    throw ValueError("model", "interpolation.mujoco: " + why +
                                  (in_each_tick() ? "; use mode: rollout, in which the bodies far from the tool stand"
                                                  : "; use a model with fewer fixed bodies"));
  }
  if (in_each_tick() && context.wall_clock) refuse_slow_model();
}

/// Steps the model from where it begins, and throws where a tick does not fit; leaves the model there.
void MujocoRollout::refuse_slow_model() {
  CoupledEngine& engine = motion_.engine();
  const EngineNumbers now = engine.numbers();
  const auto copy = [](std::span<const double> n) { return std::vector<double>(n.begin(), n.end()); };
  const std::vector<double> position = copy(now.position), velocity = copy(now.velocity),
                            activation = copy(now.activation), acceleration = copy(now.acceleration);
  DeviceState handle;
  handle.X_WD = engine.tool().X_WT;
  const double tick = tick_.seconds(), steps = std::max(1.0, std::ceil(tick / params_.substep - 1e-6));
  std::vector<double> taken;
  bool stepped = true;
  while (stepped && taken.size() < measured_ticks) {
    const double begin = clock_seconds(CLOCK_THREAD_CPUTIME_ID);
    for (double k = 0; k < steps && stepped; ++k) stepped = engine.step({}, handle, tick / steps, nullptr);
    taken.push_back(clock_seconds(CLOCK_THREAD_CPUTIME_ID) - begin);
  }
  std::sort(taken.begin(), taken.end());
  const double p99 = taken[static_cast<std::size_t>(0.99 * static_cast<double>(taken.size() - 1))];
  engine.restore({position, velocity, activation, acceleration});
  if (p99 <= most_of_tick * tick) return;
  const auto microseconds = [](double s) { return std::to_string(std::lround(1e6 * s)) + " us"; };
  throw ValueError(
      "mode", "interpolation.mujoco: the steps of " + params_.model.string() + " for a tick take " + microseconds(p99) +
                  " of CPU time on this machine (99 of 100 take less), and a tick of " + microseconds(tick) +
                  " leaves half of it to them; use mode: rollout, in which the "
                  "bodies far from the tool stand");
}

void MujocoRollout::report(Report& report) const {
  if (in_each_tick()) {
    return report.remark(name_ + ": nothing is predicted; all of the scene was stepped in each tick");
  }
  if (all_bodies_ < 2 || !moved_.any()) return;
  const int median = moved_.quantile(0.5), least = moved_.quantile(0), most = moved_.quantile(1);
  report.remark(name_ + ": of " + std::to_string(all_bodies_) + " bodies that can move, the rollout moved " +
                std::to_string(median) + " (from " + std::to_string(least) + " to " + std::to_string(most) +
                "); the others stood where each result had them");
}

/// The coupling's, on the device.
Wrench MujocoRollout::wrench() const {
  return coupling_wrench(coupling_, motion_.tool_and_handle(), torque_);
}

bool MujocoRollout::trusted(Time now) const {
  return (in_each_tick() || now - intake_.valid() < trust_.time()) && !failed_;
}

/// Whether the scene may stay where the rollout has it: a result tells of the tool alone.
bool MujocoRollout::may_keep() const {
  if (in_each_tick()) return intake_.running() && !failed_;
  const std::size_t of_tool = motion_.engine().tool_rotates() ? 6 : 3;
  return params_.restart == Params::Restart::on_disagreement && intake_.running() && !failed_ && !held_ &&
         motion_.engine().numbers().velocity.size() == of_tool;
}

/// Takes the state into use, with the scene as it is or where the state has it; or why not.
RefusalReason MujocoRollout::take_state(const EngineState& state, bool keep) {
  if (keep) return motion_.refusal(state);
  // What the handle did between a state and the samples that are known would be guessed.
  if (state.time < track_[track_.first()].stamp.valid && track_.first() > 0) return RefusalReason::late;
  // More bodies than the loop can step without memory of the heap come from a node other than prediction.mujoco.
  constexpr Trees tool_alone = 1;
  const Trees moving = motion_.engine().may_allocate(state.moving) ? tool_alone : state.moving;
  const RefusalReason why = motion_.restart(state, moving);
  if (why == RefusalReason::none) moved_.note(motion_.engine().moving_bodies());
  return why;
}

/// True where a new state has come and is gone on with.
bool MujocoRollout::take_model(Time now) {
  const Stamped<EngineState>& newest = *model.latest();
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
  trust_.learn(newest.stamp.valid, newest.value.wrench_result.force, 0, intake_.use(newest.stamp, now));
  result_wrench_ = limited(newest.value.wrench_result, newest.value.coupling);
  return !keep;
}

/// Goes through samples that the engine has not been through yet: in each tick through one after the other, otherwise
/// to the newest.
void MujocoRollout::go_on() {
  advanced_ = std::max(advanced_, track_.first());
  const std::size_t due = track_.count() - advanced_;
  const std::size_t steps = std::min(due, most_samples);
  const std::size_t way = in_each_tick() ? steps : due;
  if (way > 0 && motion_.substeps_to(track_[advanced_ + way - 1].stamp.valid) > params_.max_substeps) {
    failed_ = true;
    ++overruns_;
    return;
  }
  for (std::size_t k = 1; k <= steps && !failed_; ++k) advance_to(track_[advanced_ + way * k / steps - 1]);
  advanced_ += way;
}

void MujocoRollout::advance_to(const Stamped<DeviceState>& sample) {
  failed_ = !motion_.advance(sample, coupling_);
  if (failed_) {
    ++failed_steps_;
  } else {
    note_state();
  }
}

void MujocoRollout::note_state() {
  const PhysicsState state = motion_.tool_and_handle();
  RolloutTrust::Forces forces;
  forces[RolloutTrust::rolled] = wrench().force;
  forces[RolloutTrust::held_result] = forces[RolloutTrust::forecasted] = result_wrench_.force;
  trust_.note(motion_.time(), state.X_WT.p, forces);
}

void MujocoRollout::step(StepContext& context) {
  track_.take(device);
  if (model.latest() == nullptr || track_.count() == 0) return;
  const Time now = context.now();
  const bool corrected = take_model(now);
  if (!intake_.running() && !corrected) return;
  if (trusted(now)) go_on();
  const bool hold = !trusted(now) || lags();
  ForceState to;
  if (hold) {
    to.value = held_wrench_;
  } else {
    to = carried_.at(now, motion_.time(), motion_.tool_and_handle(), coupling_, motion_.acceleration(),
                     track_.acceleration());
    held_wrench_ = wrench();
  }
  // In each tick, the force is of the newest sample, whatever physics does beside.
  const Time valid = in_each_tick() && !hold ? motion_.time() : intake_.valid();
  if (const auto fault = segment_if_not_finite(now, {to.value, to.rate})) return segment.send(valid, *fault);
  // A sample that is finite and yet absurd would else be blended out for long.
  to.rate = limited(to.rate, coupling_, 1 / tick_.seconds());
  ForceSegment shown = blended_.go_on(now, to, one_tick_later(to, tick_, coupling_), corrected || hold != held_);
  // Zero would say nothing.
  shown.trust_time = std::max(trust_.time(), Duration{1});
  if (intake_.running() && corrected) blended_.count_correction();
  held_ = hold;
  intake_.start();
  ++(hold ? held_ticks_ : rolled_ticks_);
  segment.send(valid, shown);
}

}  // namespace tactor
