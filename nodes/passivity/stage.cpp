#include "nodes/passivity/stage.hpp"

#include <algorithm>
#include <cmath>

#include "framework/core/segment.hpp"

namespace tactor {

namespace {

Vec3 weight_of_tool(const Scene& scene) {
  const Body* tool = scene.tool();
  return tool == nullptr ? Vec3{} : tool->mass * scene.gravity_W;
}

PortEnergyOptions options_of(const StageParams& params, double damping, const NodeContext& context) {
  return {.step = params.encoder_step,
          .step_angle = params.encoder_step_angle,
          .pessimism = params.rounding,
          .damping = damping,
          .start = params.start_energy,
          .kept = params.kept_energy,
          .stiffness = params.stiffness_min,
          .weight_W = weight_of_tool(*context.scene),
          .lever = params.lever,
          .torque = context.torque};
}

/// What a ramp from `size` down by `step` a tick gives from its second tick on, where the first goes `along` m with it
/// and each further one `more` farther: sum of (size - k step) max(0, along + k more) over k = 1, 2, ... as long as
/// something is left. Between whole numbers of ticks it is their polynomial.
double given_on_ramp(double size, double step, double along, double more) {
  if (along < 0) {
    // It comes down while the handle goes on against it.
    if (!(size * more > -along * step)) return 0;
    size += along / more * step;
    along = 0;
  }
  const double ticks = size / step;
  if (ticks <= 1) return 0;
  return 0.5 * step * ticks * (ticks - 1) * (along + more * (ticks + 1) / 3);
}

bool same(const Wrench& a, const Wrench& b) {
  return a.force == b.force && a.torque == b.torque;
}

}  // namespace

PassivityStage::PassivityStage(const StageParams& params, const NodeContext& context, double damping)
    : params_(params),
      torque_(context.torque),
      tick_(Duration::from_rate(params.rate)),
      port_(options_of(params, damping, context)) {}

double PassivityStage::ramp_down(const Wrench& wrench, double along) const {
  const double more = params_.acceleration * tick() * tick();
  // A torque's ramp by its force at the lever, so that `along` is one for both.
  return given_on_ramp(norm(wrench.force), tick() * params_.force_slew, along, more) +
         given_on_ramp(norm(wrench.torque) / params_.lever, tick() * params_.torque_slew / params_.lever, along, more);
}

Wrench PassivityStage::within_energy(const Wrench& wanted) const {
  const Wrench counted = port_.without_weight(wanted);
  const Wrench left = limit(counted);
  // A sum of the same parts is not the same number.
  if (same(left, counted)) return wanted;
  // The weight is added only as far as it is wanted, because a method may display none: never against the force, and no
  // more than it.
  Vec3 weight = wanted.force - counted.force;
  if (dot(weight, wanted.force) <= 0) weight = {};
  Vec3 force = left.force + weight;
  const double size = norm(force), most = std::max(norm(left.force), norm(wanted.force));
  if (size > most) force = (most / size) * force;
  return {force, left.torque};
}

void PassivityStage::step(StepContext& context) {
  port_.take(device, commanded);
  const Stamped<ForceSegment>* newest = segment.latest();
  if (newest == nullptr || !port_.started()) return;
  // The device ticks next a tick after its newest sample, or after now where it is late.
  const Time next = std::max(port_.at(), context.now() - tick_) + tick_;
  Wrench wanted = evaluate(newest->value, next);
  if (!torque_) wanted.torque = {};
  const Wrench allowed = is_finite(wanted) ? within_energy(wanted) : wanted;
  ++steps_;
  if (!same(allowed, wanted) && is_finite(wanted)) {
    ++changed_;
    const Vec3 change = allowed.force - wanted.force;
    change_sum_ += dot(change, change);
    ForceSegment held = constant_segment(next, allowed);
    held.trust_time = newest->value.trust_time;
    passed_any_ = false;
    was_changed_ = true;
    limited.send(newest->stamp.valid, held);
    return;
  }
  // A segment that the device has is not sent again: its times may be long ago by now.
  if (passed_any_ && passed_ == newest->stamp.sequence) return;
  // After a change the device has another one, and takes this up again where it is by now.
  ForceSegment on = newest->value;
  if (was_changed_ && next >= on.end && is_finite(wanted)) {
    on = constant_segment(next, wanted);
    on.trust_time = newest->value.trust_time;
  }
  was_changed_ = false;
  passed_any_ = true;
  passed_ = newest->stamp.sequence;
  limited.send(newest->stamp.valid, on);
}

void PassivityStage::report(Report& report) const {
  const auto steps = static_cast<double>(std::max<std::uint64_t>(steps_, 1));
  report.set("passivity.changed_share", static_cast<double>(changed_) / steps);
  report.set("passivity.change_rms_N", std::sqrt(change_sum_ / steps));
  report.set("passivity.least_energy_J", port_.least());
}

}  // namespace tactor
