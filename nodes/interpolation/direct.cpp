#include "nodes/interpolation/direct.hpp"

#include <algorithm>
#include <utility>

#include "nodes/interpolation/not_finite.hpp"
#include "nodes/physics/mechanics/rollout_parameters.hpp"
#include "nodes/physics/mechanics/scene_model.hpp"

namespace tactor {

namespace {

/// Samples that one tick steps through at most: to catch up from a result, or after samples that came late.
constexpr std::size_t most_samples_a_tick = 4;

}  // namespace

NodeInfo Direct::declare() {
  Declare<Direct> node("interpolation.direct",
                       "Steps the scene once per sample of the handle, if that fits in a tick.");
  node.details(
          "Use it for scenes whose physics step with its contact query fits in a tick of the device (`tactor check "
          "--explain` measures that). At each sample of the handle, the step of the dynamics moves all moving bodies, "
          "against contacts found at their present poses. The node displays the coupling's wrench and its rate, so the "
          "tick until the device shows it adds no delay. It starts from the first result of `bodies`, goes through the "
          "samples of the handle since then, and needs no later result.\nIf a step does not fit, the segment of "
          "`otherwise` is displayed. This happens if the contact query needs more than `most_work`, if the step does "
          "not converge, or if its force is not finite. The next result of `bodies` is the next try. When the node "
          "changes over, the displayed force stays as it is, and the difference decays as tau^2 e'' + 2 tau e' + e = "
          "0.\nAfter a fall-back, the device's gate waits until physics has passed the last sample that was stepped "
          "to. Set `stale_after` to at least two intervals of physics.\nThe node does not correct the bodies of the "
          "asynchronous pipeline. Where several bodies move, the two may drift apart.")
      .realtime_safe()
      .input("device", &Direct::device, {.doc = "every sample of the handle", .queue = {QueuePolicy::drop_oldest, 64}})
      .input("coupling", &Direct::coupling, {.doc = "the spring and damper between handle and tool"})
      .input("bodies", &Direct::bodies, {.doc = "the moving bodies of a physics result, to start from"})
      .needs_scene_law("direct steps the scene's own bodies in each tick")
      .input("otherwise", &Direct::otherwise, {.doc = "what to display if a step does not fit"})
      .output("segment", &Direct::segment, "the force over one tick, stamped as the newest sample that was stepped to")
      .real("blend_time", &Params::blend_time,
            {.doc = "tau, the time constant of each of the two equal poles with which a change decays",
             .unit = "s",
             .default_value = 0.002,
             .min = 0,
             .max = 1,
             .above_min = true})
      .unneeded(nothing_moves)
      .haptic_rate(&Params::rate, {.doc = "ticks per second"});
  declare_rollout(node);
  declare_query(node, 2000, "the step does not fit");
  return node.role(Role::interpolation)
      .metric("direct.ticks", "1", "ticks that showed the force of a step of their own", Better::neither,
              &Direct::ticks_)
      .metric("direct.fallback_ticks", "1", "ticks that showed `otherwise`, from the first step on", Better::lower,
              &Direct::fallback_ticks_)
      .metric("fallbacks", "1", "ticks that showed `otherwise`, from the first step on", Better::lower,
              &Direct::fallback_ticks_)
      .summed()
      .metric("direct.rejected_results", "1", "results and couplings that were not usable", Better::lower,
              [](const Direct& self) { return self.start_.refusals().refused(); })
      .metric("direct.rejected_samples", "1", "samples that were not finite, or too late to be used", Better::lower,
              [](const Direct& self) { return self.track_.rejected(); })
      .metric("direct.work_mean", "1", "work of the contact query of a step, mean", Better::lower,
              [](const Direct& self) { return self.scene_.work_mean(); })
      .metric("direct.work_most", "1", "work of the contact query of a step, most", Better::lower,
              [](const Direct& self) { return self.scene_.work_most(); })
      .info();
}

Direct::Direct(const Params& params, const NodeContext& context)
    : torque_(context.torque),
      tick_(Duration::from_rate(params.rate)),
      scene_{surface_contacts(params, context), nullptr, rollout_model("interpolation.direct", params, context)},
      carried_(tick_, torque_),
      blended_(tick_, params.blend_time) {
  refuse_deformable(*context.scene, "interpolation.direct steps", "--over local");
}

/// Puts the bodies where the newest result has them, if that is a new one.
void Direct::begin(Time now) {
  const Stamped<BodyStates>* result = bodies.latest();
  if (result == nullptr || track_.count() == 0 || result->stamp.valid > now || !start_.is_new(*result)) return;
  // Samples later than the result are still to be gone through.
  const std::size_t later = track_.after(result->stamp.valid);
  if (!start_.begin(*result, track_.at(result->stamp.valid, scene_.rollout().tool_rotates()), scene_.rollout())) return;
  advanced_ = later;
  stepping_ = catching_up_ = true;
}

void Direct::fall_back() {
  stepping_ = catching_up_ = false;
  counts_ = true;
}

/// Goes through the samples that the bodies have not been through yet, or the next of them.
void Direct::go_on() {
  advanced_ = std::max(advanced_, track_.first());
  const std::size_t due = track_.count() - advanced_;
  const std::size_t steps = std::min(due, most_samples_a_tick);
  // From a result on each sample counts; where samples came late, a tick goes through all of them in longer steps.
  const std::size_t way = catching_up_ ? steps : due;
  for (std::size_t k = 1; k <= steps; ++k) {
    const bool converged = scene_.advance(track_[advanced_ + way * k / steps - 1]);
    if (!converged || !scene_.rollout().on_surface()) return fall_back();
  }
  advanced_ += way;
  // A result itself is not shown: its force is of a sample that has been.
  if (way > 0 && advanced_ == track_.count()) catching_up_ = false;
}

/// False where the force is not finite.
bool Direct::aim_at_bodies(Time now) {
  const LocalRollout& rollout = scene_.rollout();
  ForceState aim = carried_.at(now, rollout, track_.acceleration());
  if (!is_finite(aim.value) || !is_finite(aim.rate)) return false;
  // A sample that is finite and yet absurd would else be blended out for long.
  const CouplingParameters& spring = rollout.model().coupling;
  aim.rate = limited(aim.rate, spring, 1 / tick_.seconds());
  aim_ = {.now = aim,
          .later = one_tick_later(aim, tick_, spring),
          .valid = rollout.model().time,
          .changed = !aim_.of_bodies,
          .of_bodies = true};
  return true;
}

/// False where there is nothing to display yet.
bool Direct::aim_at_otherwise(Time now) {
  const Stamped<ForceSegment>* newest = otherwise.latest();
  if (newest == nullptr) {
    // Whatever was shown last stays.
    aim_.changed = std::exchange(aim_.of_bodies, false);
    aim_.now = aim_.later = {aim_.now.value, {}, {}};
    return ticks_ > 0;
  }
  const std::uint64_t before = std::exchange(otherwise_shown_, newest->stamp.sequence);
  const auto state_at = [&](Time t) {
    ForceState state = displayed(newest->value, t);
    if (start_.coupling() != nullptr) state.value = limited(state.value, *start_.coupling());
    if (!torque_) state.value.torque = state.rate.torque = {};
    state.curvature = {};
    return state;
  };
  aim_ = {.now = state_at(now),
          .later = state_at(now + tick_),
          .valid = newest->stamp.valid,
          .trust_time = newest->value.trust_time,
          .changed = aim_.of_bodies || newest->stamp.sequence != before};
  return true;
}

void Direct::step(StepContext& context) {
  const Time now = context.now();
  track_.take(device);
  if (coupling.latest() != nullptr) start_.take(*coupling.latest(), scene_.rollout());
  if (!stepping_) begin(now);
  if (stepping_) go_on();
  const bool steps = is_up_to_date() && aim_at_bodies(now);
  if (is_up_to_date() && !steps) fall_back();
  if (!steps && !aim_at_otherwise(now)) return;
  if (steps) {
    counts_ = true;
    ++ticks_;
  } else if (counts_) {
    ++fallback_ticks_;
  }
  if (const auto fault =
          segment_if_not_finite(now, {aim_.now.value, aim_.now.rate, aim_.later.value, aim_.later.rate})) {
    // The next aim that is finite is a change.
    otherwise_shown_ = std::numeric_limits<std::uint64_t>::max();
    aim_.now = aim_.later = {};
    return segment.send(aim_.valid, *fault);
  }
  ForceSegment shown = blended_.go_on(now, aim_.now, aim_.later, aim_.changed);
  shown.trust_time = aim_.trust_time;
  segment.send(aim_.valid, shown);
}

}  // namespace tactor
