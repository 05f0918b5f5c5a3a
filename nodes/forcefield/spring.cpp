#include "nodes/forcefield/spring.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "framework/core/segment.hpp"

namespace tactor {

NodeInfo SpringForceField::declare() {
  using F = SpringForceField;
  return Declare<F>("forcefield.spring", "A spring and a damper at the device's sampled position: a virtual wall.")
      .details(
          "F = -K (x - x_0) - B v along one axis, evaluated at each sample of the device and held until the next. v is "
          "the difference of the last two positions over the time between. The two-sided spring always acts, and the "
          "loop is linear: this is the case in which the theory of sampled virtual walls holds. The one-sided spring "
          "acts below `position` and never pulls. It needs no scene and no physics. It shows what a wall can bear if "
          "the device's tick is the only delay.")
      .realtime_safe()
      .input("device", &F::device, {.doc = "the device's state"})
      .output("force", &F::force, "the wall's force on the device")
      .output("segment", &F::segment, "the same, held")
      .real("stiffness", &Params::stiffness, {.doc = "K", .unit = "N/m", .default_value = 1000, .min = 0, .max = 1e7})
      .real(
          "damping", &Params::damping,
          {.doc = "B; a negative value generates energy", .unit = "N s/m", .default_value = 0, .min = -1e4, .max = 1e4})
      .choice("sides", &Params::sides, {{"one", Sides::one}, {"two", Sides::two}}, std::optional(Sides::one),
              "one: a wall below `position`; two: a spring that pulls the handle to `position` from both sides")
      .choice("velocity", &Params::velocity, {{"difference", Velocity::difference}, {"device", Velocity::device}},
              std::optional(Velocity::difference),
              "difference: from the last two positions; device: the device's own estimate")
      .choice("axis", &Params::axis, {{"x", AxisName::x}, {"y", AxisName::y}, {"z", AxisName::z}},
              std::optional(AxisName::z), "the axis of the world that the force acts along")
      .real("position", &Params::position,
            {.doc = "x_0, where the spring is slack", .unit = "m", .default_value = 0, .min = -10, .max = 10})
      .haptic_rate(&Params::rate, {.doc = "ticks per second"})
      .role(Role::force_field)
      .metric("forcefield.rejected_samples", "1", "samples of the device that were not usable", Better::lower,
              [](const SpringForceField& self) { return self.refused_.refused(); })
      .info();
}

SpringForceField::SpringForceField(const Params& params, const NodeContext&)
    : params_(params), axis_(static_cast<int>(params.axis)) {}

double SpringForceField::force_at(double x, double v) const {
  const double linear = -params_.stiffness * (x - params_.position) - params_.damping * v;
  if (params_.sides == Sides::two) return linear;
  return x < params_.position ? std::max(linear, 0.0) : 0.0;
}

void SpringForceField::take(Time now, const Stamped<DeviceState>& sample) {
  const double x = sample.value.X_WD.p[axis_], shown = sample.value.V_WD.v[axis_];
  const Time t = sample.stamp.valid;
  const RefusalReason refusal = !std::isfinite(x) || !std::isfinite(shown) ? RefusalReason::not_finite
                                : any_ && t <= t_                          ? RefusalReason::late
                                                                           : RefusalReason::none;
  refused_.count(refusal);
  if (refusal != RefusalReason::none) return;
  const double difference = any_ ? (x - x_) / (t - t_).seconds() : 0.0;
  any_ = true;
  x_ = x;
  t_ = t;
  Wrench force_D_W;
  force_D_W.force[axis_] = force_at(x, params_.velocity == Velocity::difference ? difference : shown);
  force.send(t, force_D_W);
  segment.send(t, constant_segment(now, force_D_W));
}

void SpringForceField::step(StepContext& context) {
  Stamped<DeviceState> sample;
  while (samples_.next(device, sample)) take(context.now(), sample);
}

}  // namespace tactor
