#include "nodes/interpolation/linear.hpp"

#include "framework/core/segment.hpp"
#include "nodes/interpolation/not_finite.hpp"

namespace tactor {

NodeInfo LinearInterpolation::declare() {
  Declare<LinearInterpolation> node("interpolation.linear",
                                    "A straight line from the displayed to the predicted force.");
  node.details(
          "The line starts at the value displayed when the forecast arrives. It reaches the predicted value after the "
          "estimated physics period. If the next forecast is late, the value reached is held. If it is early, the next "
          "line starts from the value displayed then.")
      .realtime_safe()
      .input("forecast", &LinearInterpolation::forecast,
             {.doc = "the predicted force to reach", .trigger = Trigger::yes})
      .output("segment", &LinearInterpolation::segment, "a line over one estimated period");
  return declare_period(node).cheaper("interpolation.none").role(Role::interpolation).info();
}

LinearInterpolation::LinearInterpolation(const Params& params, const NodeContext&) : period_(params) {}

void LinearInterpolation::step(StepContext& context) {
  const Stamped<Forecast>* newest = forecast.latest();
  if (newest == nullptr) return;
  period_.update(newest->stamp.valid);
  const Time now = context.now();
  if (const auto fault = segment_if_not_finite(now, {newest->value.predicted_D_W[0]}))
    return segment.send(newest->stamp.valid, *fault);
  const Wrench displayed = evaluate(curve_, now);
  curve_ = {now, now + period_.value(), {displayed, newest->value.predicted_D_W[0] - displayed}};
  segment.send(newest->stamp.valid, curve_);
}

}  // namespace tactor
