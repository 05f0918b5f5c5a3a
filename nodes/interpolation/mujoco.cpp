#include "nodes/interpolation/mujoco.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "framework/core/clock.hpp"
#include "framework/core/value_error.hpp"
#include "nodes/interpolation/declare_trust.hpp"

namespace tactor {

namespace {

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
  node.metric("rollout.moving_bodies", "1",
              "bodies that the rollout moved, each with what hangs on it; the others stood. Median of the results",
              Better::neither, [](const MujocoRollout& self) { return self.rollout_.moved().quantile(0.5); })
      .metric("rollout.least_moving_bodies", "1", "the same, the least of all results", Better::neither,
              [](const MujocoRollout& self) { return self.rollout_.moved().quantile(0); })
      .metric("rollout.most_moving_bodies", "1", "the same, the most of all results", Better::neither,
              [](const MujocoRollout& self) { return self.rollout_.moved().quantile(1); })
      .metric("rollout.disagreements", "1", "times that the tool went to where physics kept having it", Better::lower,
              [](const MujocoRollout& self) { return self.rollout_.trust().disagreements(); })
      .left_out_when([](const Params& p, const MetricUse&) {
        return std::string(p.restart == Params::Restart::always ? "the scene goes back to every result" : "");
      });
}

NodeInfo MujocoRollout::declare() {
  Declare<MujocoRollout> node("interpolation.mujoco", "Continues MuJoCo's scene through each sample of the handle.");
  node.details(
      "It is the display side of prediction.mujoco. The node has a scene of MuJoCo of its own. It puts it into the "
      "newest state and makes one or more sub-steps per tick, with the bodies that the state says; the others stand "
      "where it has them. It displays the coupling's wrench and its rate, so the tick until the device shows it adds "
      "no delay. When a state arrives, the displayed force stays as it is. The difference decays as tau^2 e'' + 2 tau "
      "e' + e = 0, from a rate between 0 and -e / tau, so it neither grows nor overshoots. A result is trusted until "
      "it is older than `trust_time` and than three intervals between results; then, or if a step fails, the last "
      "force is held. The same holds if a tick would need more than `max_substeps`, after a gap in the samples of the "
      "handle. The segments tell the device for how long a result is trusted.\nA step takes the time that MuJoCo "
      "takes, for which nothing gives a bound: measure it on your scene before you put the node into the real-time "
      "lane. With `mode: each_tick` it goes on from the first result with all bodies and never goes back. Then nothing "
      "is predicted, and physics is stepped for the report alone.\nMuJoCo allocates memory in the steps of large "
      "models. The node refuses a model that is too large even where the tool alone moves.");
  declare_engine_rollout(node, "the state to continue from, as prediction.mujoco sends it", "MuJoCo");
  declare_metrics(node);
  declare_engine_model(node, false, 2.5e-4);
  node.as_in("model", Role::dynamics).as_in("tool", Role::dynamics).as_in("keyframe", Role::dynamics);
  declare_mode(node);
  declare_restart_of_scene(node);
  return node.coarser("substep", {5e-4, 1e-3}).info();
}

MujocoRollout::MujocoRollout(const Params& params, const NodeContext& context)
    : name_(context.name),
      in_each_tick_(params.mode == Params::Mode::each_tick),
      engine_(load_engine("interpolation.mujoco", params, context, !in_each_tick_)),
      all_bodies_(engine_->moving_bodies()),
      rollout_(*engine_, params.substep, params, context.torque) {
  constexpr Trees tool_alone = 1;
  if (const std::string why = engine_->allocates(tool_alone); !why.empty()) {
    throw ValueError("model", "interpolation.mujoco: " + why +
                                  (in_each_tick_ ? "; use mode: rollout, in which the bodies far from the tool stand"
                                                 : "; use a model with fewer fixed bodies"));
  }
  if (in_each_tick_ && context.wall_clock) refuse_slow_model(params);
}

/// Steps the model from where it begins, and throws where a tick does not fit; leaves the model there.
void MujocoRollout::refuse_slow_model(const Params& params) {
  CoupledEngine& engine = *engine_;
  const EngineNumbers now = engine.numbers();
  const auto copy = [](std::span<const double> n) { return std::vector<double>(n.begin(), n.end()); };
  const std::vector<double> position = copy(now.position), velocity = copy(now.velocity),
                            activation = copy(now.activation), acceleration = copy(now.acceleration);
  DeviceState handle;
  handle.X_WD = engine.tool().X_WT;
  const double tick = Duration::from_rate(params.rate).seconds(),
               steps = std::max(1.0, std::ceil(tick / params.substep - 1e-6));
  std::vector<double> taken;
  bool stepped = true;
  while (stepped && taken.size() < measured_ticks) {
    const double begin = clock_seconds(CLOCK_THREAD_CPUTIME_ID);
    for (double k = 0; k < steps && stepped; ++k) stepped = engine.step({}, handle, tick / steps, nullptr);
    taken.push_back(clock_seconds(CLOCK_THREAD_CPUTIME_ID) - begin);
  }
  std::sort(taken.begin(), taken.end());
  const double p99 = taken[static_cast<std::size_t>(0.99 * static_cast<double>(taken.size() - 1))];
  engine.restore({position, velocity, activation, acceleration, now.X_WT, now.V_WT});
  if (p99 <= most_of_tick * tick) return;
  const auto microseconds = [](double s) { return std::to_string(std::lround(1e6 * s)) + " us"; };
  throw ValueError(
      "mode", "interpolation.mujoco: the steps of " + params.model.string() + " for a tick take " + microseconds(p99) +
                  " of CPU time on this machine (99 of 100 take less), and a tick of " + microseconds(tick) +
                  " leaves half of it to them; use mode: rollout, in which the "
                  "bodies far from the tool stand");
}

void MujocoRollout::report(Report& report) const {
  if (in_each_tick_) {
    return report.remark(name_ + ": nothing is predicted; all of the scene was stepped in each tick");
  }
  if (all_bodies_ < 2 || !rollout_.moved().any()) return;
  const MovedBodies& moved = rollout_.moved();
  const int median = moved.quantile(0.5), least = moved.quantile(0), most = moved.quantile(1);
  report.remark(name_ + ": of " + std::to_string(all_bodies_) + " bodies that can move, the rollout moved " +
                std::to_string(median) + " (from " + std::to_string(least) + " to " + std::to_string(most) +
                "); the others stood where each result had them");
}

}  // namespace tactor
