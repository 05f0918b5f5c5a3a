#include "nodes/interpolation/bspline.hpp"

#include "nodes/interpolation/force_state.hpp"
#include "nodes/interpolation/not_finite.hpp"

namespace tactor {

std::array<Wrench, 6> bspline_cubic(const std::array<Wrench, 4>& P) {
  return {(1.0 / 6.0) * (P[0] + 4.0 * P[1] + P[2]), 0.5 * (P[2] - P[0]), 0.5 * (P[0] - 2.0 * P[1] + P[2]),
          (1.0 / 6.0) * ((P[3] - P[0]) + 3.0 * (P[1] - P[2]))};
}

std::array<Wrench, 6> bspline_continued(const Wrench& value, const Wrench& slope, const Wrench& curvature,
                                        const Wrench& next) {
  const Wrench P1 = value - (1.0 / 6.0) * curvature;
  const Wrench P2 = P1 + slope + 0.5 * curvature;
  const Wrench P0 = P1 - slope + 0.5 * curvature;
  std::array<Wrench, 6> c = bspline_cubic({P0, P1, P2, next});
  // The join is exact by construction; the control points would give it up to rounding.
  c[0] = value;
  c[1] = slope;
  c[2] = 0.5 * curvature;
  return c;
}

NodeInfo BSpline::declare() {
  Declare<BSpline> node("interpolation.bspline", "A smooth curve by uniform cubic B-splines.");
  node.details(
          "Each forecast gives one segment, as long as the estimated physics period. The control points are F_{t-2}, "
          "F_{t-1}, F_t, F_{t+1|t}. The past ones are the actual forces, or all as predicted (`control_points`). "
          "`join: paper` is that segment as printed. With predicted points, neighbouring segments join with C2 if "
          "forecasts arrive exactly one estimated period apart, and jump otherwise. With actual points, they always "
          "jump by a sixth of the prediction error. `join: hermite` starts from the displayed value and slope and "
          "reaches the value and slope of the printed segment's end, so it is C1 and no later. `join: continuous` "
          "takes the three past control points that follow uniquely from the value, slope and curvature of the "
          "displayed curve. It is C2 if forecasts come early or the period changes. But it is later than the others if "
          "the period is uneven, and overshoots to many times the input if the period jumps between 3 and 40 ms. If a "
          "forecast is late (u >= 1), the end value is held, and the next segment starts from it at rest.\nSource: Hou "
          "and Sourina, Real-time Adaptive Prediction Method for Smooth Haptic Rendering.")
      .realtime_safe()
      .input("forecast", &BSpline::forecast,
             {.doc = "the physics force and the predicted force", .trigger = Trigger::yes})
      .output("segment", &BSpline::segment, "a B-spline segment over one estimated period")
      .choice("control_points", &Params::control_points,
              {{"mixed", ControlPoints::mixed}, {"predicted", ControlPoints::predicted}},
              std::optional(ControlPoints::mixed),
              "the past control points: actual forces (mixed), or the forces predicted for them; `join: continuous` "
              "ignores this")
      .choice("join", &Params::join,
              {{"paper", Join::paper}, {"hermite", Join::hermite}, {"continuous", Join::continuous}},
              std::optional(Join::hermite),
              "the segment as printed in the paper (paper), or one that continues the displayed curve with C1 "
              "(hermite) or C2 (continuous)");
  return declare_period(node)
      .cheaper("interpolation.linear")
      .cheaper("interpolation.none")
      .role(Role::interpolation)
      .metric("interpolation.late", "1", "forecasts that came after the end of the segment", Better::lower,
              &BSpline::late_)
      .metric("interpolation.early", "1", "forecasts that came before the end of the segment", Better::neither,
              &BSpline::early_)
      .info();
}

BSpline::BSpline(const Params& params, const NodeContext& context)
    : params_(params), torque_(context.torque), period_(params) {}

ForceSegment BSpline::as_printed(const Forecast& f, Time begin, Duration length) {
  if (!any_) control_.fill(f.current_D_W);
  // `control_` holds P_0..P_3 of the segment before; each moves on by one place.
  control_ = {control_[1], control_[2], control_[3], f.predicted_D_W[0]};
  if (params_.control_points == ControlPoints::mixed) control_[2] = f.current_D_W;
  return {begin, begin + length, bspline_cubic(control_)};
}

void BSpline::step(StepContext& context) {
  const Stamped<Forecast>* newest = forecast.latest();
  if (newest == nullptr) return;
  const Time now = context.now();
  Forecast f = newest->value;
  if (!torque_) f.current_D_W.torque = f.predicted_D_W[0].torque = {};
  period_.update(newest->stamp.valid);
  if (const auto fault = segment_if_not_finite(now, {f.current_D_W, f.predicted_D_W[0]}))
    return segment.send(newest->stamp.valid, *fault);
  if (any_ && now > curve_.end) ++late_;
  if (any_ && now < curve_.end) ++early_;
  const ForceState from = displayed(curve_, now);
  const Duration length = period_.value();
  const double T = length.seconds();
  curve_ = as_printed(f, now, length);
  if (params_.join == Join::hermite) curve_ = cubic_between(now, length, from, displayed(curve_, curve_.end));
  if (params_.join == Join::continuous) {
    curve_.c = bspline_continued(from.value, T * from.rate, (T * T) * from.curvature, f.predicted_D_W[0]);
  }
  any_ = true;
  segment.send(newest->stamp.valid, curve_);
}

}  // namespace tactor
