#include "nodes/interpolation/gain.hpp"

#include <algorithm>

#include "framework/node/declare.hpp"
#include "nodes/interpolation/force_state.hpp"

namespace tactor {

NodeInfo Gain::declare() {
  return Declare<Gain>("interpolation.gain", "Displays a force times a factor, which may change during the run.")
      .details(
          "Use it in experiments. A factor of 0 mutes the force between two intervals. A factor of 1.1 makes "
          "everything that is felt stiffer, more viscous and rougher by a tenth. Set `factor` while a session runs: it "
          "is reached along 3 s^2 - 2 s^3 within `ramp`. A factor above 1 also multiplies the stiffness in the loop "
          "through the hand, so a loop that is stable at 1 may be unstable above.")
      .realtime_safe()
      .input("force", &Gain::force, {.doc = "the force to scale", .trigger = Trigger::yes})
      .output("segment", &Gain::segment, "the force times the factor")
      .real("factor", &Params::factor,
            {.doc = "what the force is multiplied by", .default_value = 1, .min = 0, .max = 10})
      .real("ramp", &Params::ramp,
            {.doc = "time in which a new factor is reached", .unit = "s", .default_value = 0.1, .min = 0.01, .max = 10})
      .means("ramp", ParamMeaning::ramp)
      .tunable({"factor"})
      .haptic_rate(&Params::rate, {.doc = "ticks per second while the factor changes"})
      .role(Role::interpolation)
      .info();
}

Gain::Gain(const Params& params, const NodeContext&)
    : params_(params),
      tick_(Duration::from_rate(params.rate)),
      from_(params.factor),
      to_(params.factor),
      ramp_(params.ramp) {}

Gain::Factor Gain::factor(Time t) const {
  const double s = std::clamp((t - begin_).seconds() / ramp_.seconds(), 0.0, 1.0);
  const double change = to_ - from_;
  return {from_ + change * s * s * (3 - 2 * s), change * 6 * s * (1 - s) / ramp_.seconds()};
}

void Gain::step(StepContext& context) {
  const Time now = context.now();
  if (params_.factor != to_) {
    from_ = factor(now).value;
    to_ = params_.factor;
    begin_ = now;
    changing_ = true;
  }
  if (changing_ && now >= begin_ + ramp_) {
    changing_ = false;
    from_ = to_;
    passed_.reset();
  }
  const Stamped<ForceSegment>* newest = force.latest();
  if (newest == nullptr) return;
  if (!changing_) {
    if (passed_ == newest->stamp.sequence) return;
    passed_ = newest->stamp.sequence;
    ForceSegment scaled = newest->value;
    for (Wrench& c : scaled.c) c = to_ * c;
    return segment.send(newest->stamp.valid, scaled);
  }
  const auto scaled_at = [&](Time t) {
    const ForceState state = displayed(newest->value, t);
    const Factor g = factor(t);
    return ForceState{g.value * state.value, g.value * state.rate + g.rate * state.value, {}};
  };
  ForceSegment changing = cubic_between(now, tick_, scaled_at(now), scaled_at(now + tick_));
  changing.trust_time = newest->value.trust_time;
  segment.send(newest->stamp.valid, changing);
}

}  // namespace tactor
