#include "nodes/passivity/stage.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "framework/core/energy_ramp.hpp"
#include "framework/core/segment.hpp"
#include "framework/core/tool_weight.hpp"

namespace tactor {

namespace {

PortEnergyOptions options_of(const StageParams& params, double damping, const NodeContext& context) {
  return {.step = params.encoder_step,
          .step_angle = params.encoder_step_angle,
          .pessimism = params.rounding,
          .acceleration = params.acceleration,
          .tick = Duration::from_rate(params.rate),
          .damping = damping,
          .start = params.start_energy,
          .kept = params.kept_energy,
          .stiffness = params.stiffness_min,
          .weight_W = params.tool_weight ? tool_weight(*context.scene) : Vec3{},
          .lever = params.lever,
          .torque = context.torque};
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

double PassivityStage::share_that_takes(const Wrench& wrench, double along) const {
  const double more = params_.acceleration * tick() * tick();
  if (along >= 0) return 0;
  if (more == 0) return std::numeric_limits<double>::infinity();
  const auto share = [&](double size, double slew) { return -along / more * tick() * slew / size; };
  // Of a part that is zero it is infinite.
  return std::min(share(norm(wrench.force), params_.force_slew), share(norm(wrench.torque), params_.torque_slew));
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

Wrench PassivityStage::on_its_way(Time tick) const {
  const ForceSegment* sent = sent_.at(tick);
  if (sent == nullptr) return port_.held();
  Wrench wrench = evaluate(*sent, tick);
  if (!torque_) wrench.torque = {};
  return is_finite(wrench) ? port_.without_weight(wrench) : Wrench{};
}

double PassivityStage::energy_then(const Foretold& foretold) const {
  double energy = port_.energy();
  for (int i = 0; i < ahead_; ++i) {
    const Wrench wrench = i == 0 ? port_.held() : on_its_way(port_.at() + tick_ * i);
    energy -= work(wrench, foretold.along) + farther(foretold, i) * std::sqrt(square(wrench, params_.lever));
  }
  return energy;
}

void PassivityStage::send(Time valid, Time from, const ForceSegment& sent) {
  sent_.send(from, sent);
  limited.send(valid, sent);
}

void PassivityStage::step(StepContext& context) {
  port_.take(device, commanded);
  const Stamped<ForceSegment>* newest = segment.latest();
  if (newest == nullptr || !port_.started()) return;
  ahead_ = ticks_ahead(port_.at(), context.now(), tick_);
  most_seen_ahead_ = std::max(most_seen_ahead_, ahead_);
  const Time next = port_.at() + tick_ * ahead_;
  if (steps_ > 0) most_held_ = std::max(most_held_, (next - decided_for_).ns / tick_.ns);
  decided_for_ = next;
  Wrench wanted = evaluate(newest->value, next);
  if (!torque_) wanted.torque = {};
  Wrench allowed = wanted;
  if (is_finite(wanted)) allowed = ahead_ < most_ahead ? within_energy(wanted) : Wrench{};
  ++steps_;
  if (!same(allowed, wanted) && is_finite(wanted)) {
    ++changed_;
    const Vec3 change = allowed.force - wanted.force;
    change_sum_ += dot(change, change);
    ForceSegment held = constant_segment(next, allowed);
    held.trust_time = newest->value.trust_time;
    passed_any_ = false;
    was_changed_ = true;
    send(newest->stamp.valid, next, held);
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
  send(newest->stamp.valid, next, on);
}

double PassivityStage::changed_share() const {
  return static_cast<double>(changed_) / static_cast<double>(std::max<std::uint64_t>(steps_, 1));
}

double PassivityStage::change_rms() const {
  return std::sqrt(change_sum_ / static_cast<double>(std::max<std::uint64_t>(steps_, 1)));
}

}  // namespace tactor
