#include "nodes/interpolation/lowpass.hpp"

#include "nodes/interpolation/not_finite.hpp"

namespace tactor {

NodeInfo LowPass::declare() {
  return Declare<LowPass>("interpolation.lowpass", "Smooths the held force by a critically damped low-pass.")
      .details(
          "tau^2 F'' + 2 tau F' + F = F_t for force and torque, solved exactly from tick to tick. It is the baseline "
          "for every smooth method: it buys its smoothness with a delay of 2 tau. Each tick sends the cubic that has "
          "the filter's values and slopes at both ends. The node ignores the predicted force.")
      .realtime_safe()
      .input("forecast", &LowPass::forecast, {.doc = "the force to follow"})
      .output("segment", &LowPass::segment, "the filter's curve over one tick")
      .real("time_constant", &Params::time_constant,
            {.doc = "tau, the time constant of each of the two equal poles",
             .unit = "s",
             .default_value = 0.004,
             .min = 0,
             .max = 1,
             .above_min = true})
      .tunable({"time_constant"})
      .haptic_rate(&Params::rate, {.doc = "ticks per second"})
      .cheaper("interpolation.linear")
      .cheaper("interpolation.none")
      .role(Role::interpolation)
      .info();
}

LowPass::LowPass(const Params& params, const NodeContext&)
    : tau_(params.time_constant.seconds()), next_tau_(tau_), tick_(Duration::from_rate(params.rate)) {}

ForceState LowPass::after(const ForceState& state, double h) const {
  const ForceState target{target_, {}, {}};
  return target + decayed_twice(state - target, h, tau_);
}

void LowPass::step(StepContext& context) {
  const Stamped<Forecast>* newest = forecast.latest();
  if (newest == nullptr) return;
  const Time now = context.now();
  if (const auto fault = segment_if_not_finite(now, {newest->value.current_D_W}))
    return segment.send(newest->stamp.valid, *fault);
  // The old target held until this tick, however long ago the last one was.
  if (running_) state_ = after(state_, (now - last_).seconds());
  tau_ = next_tau_;
  running_ = true;
  last_ = now;
  target_ = newest->value.current_D_W;
  segment.send(newest->stamp.valid, cubic_between(now, tick_, state_, after(state_, tick_.seconds())));
}

}  // namespace tactor
