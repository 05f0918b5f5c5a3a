#include "nodes/interpolation/blend.hpp"

#include "nodes/interpolation/not_finite.hpp"

namespace tactor {

NodeInfo Blend::declare() {
  return Declare<Blend>("interpolation.blend", "Displays the forecast of the present time, and blends its changes in.")
      .details(
          "F(t) = G(t) + e(t). G is the newest forecast as a curve through F_t at its stamp and the predicted steps at "
          "stamp + i T. It is evaluated at the time of display, so the delay of a result is predicted and not shown. e "
          "is the difference between the displayed force and G. When a forecast arrives, the displayed force stays as "
          "it is, and e decays from there: tau^2 e'' + 2 tau e' + e = 0 with `continuity: c1`, (tau d/dt + 1)^3 e = 0 "
          "with `c2`, where tau is the `blend_time`. The equations are solved exactly from step to step. Each tick, "
          "and each forecast that arrives between two, sends the cubic (c1) or quintic (c2) that has the values, "
          "slopes (and curvatures) of F at both ends of a tick, so the displayed force is C1 or C2 whenever forecasts "
          "arrive; a missed tick holds it at rest. In the real-time lane a forecast waits for the next tick. If the "
          "next forecast comes later than the last predicted step, that step is held. A shorter blend follows more "
          "closely and is rougher. Behind `prediction.hold` the displayed force is the held one, low-pass filtered.")
      .realtime_safe()
      .input("forecast", &Blend::forecast,
             {.doc = "the physics force and the predicted forces", .trigger = Trigger::yes})
      .output("segment", &Blend::segment, "the displayed curve over one tick")
      .real("blend_time", &Params::blend_time,
            {.doc = "tau, the time constant of each of the equal poles of the decay",
             .unit = "s",
             .default_value = 0.002,
             .min = 0,
             .max = 1,
             .above_min = true})
      .tunable({"blend_time"})
      .choice("shape", &Params::shape, {{"linear", CurveShape::linear}, {"cubic", CurveShape::cubic}},
              std::optional(CurveShape::linear),
              "the curve between the steps of the forecast: straight lines, or the cubic through the nearest four")
      .choice("continuity", &Params::continuity, {{"c1", Continuity::c1}, {"c2", Continuity::c2}},
              std::optional(Continuity::c1), "what is continuous: value and slope (c1), or the curvature too (c2)")
      .haptic_rate(&Params::rate, {.doc = "ticks per second"})
      .cheaper("interpolation.linear")
      .cheaper("interpolation.none")
      .role(Role::interpolation)
      .metric("interpolation.late", "1", "forecasts that came after the last step of the one before", Better::lower,
              &Blend::late_)
      .info();
}

Blend::Blend(const Params& params, const NodeContext&) : params_(params), tick_(Duration::from_rate(params.rate)) {}

void Blend::step(StepContext& context) {
  const Stamped<Forecast>* newest = forecast.latest();
  if (newest == nullptr) return;
  const Time now = context.now();
  if (const auto fault = segment_if_not_finite(now, newest->value)) return segment.send(newest->stamp.valid, *fault);
  const ForecastCurve curve(*newest, params_.shape);
  if (curve.is_over(now)) ++late_;
  const ForceState from = displayed(shown_, now);
  const ForceState difference = from - curve.at(now);
  const ForceState aim = curve.at(now + tick_);
  const double tau = params_.blend_time.seconds();
  if (params_.continuity == Continuity::c1) {
    shown_ = cubic_between(now, tick_, from, aim + decayed_twice(difference, tick_.seconds(), tau));
  } else {
    shown_ = quintic_between(now, tick_, from, aim + decayed_thrice(difference, tick_.seconds(), tau));
  }
  segment.send(newest->stamp.valid, shown_);
}

}  // namespace tactor
