#include "nodes/interpolation/none.hpp"

#include "framework/core/segment.hpp"

namespace tactor {

NodeInfo NoInterpolation::declare() {
  return Declare<NoInterpolation>("interpolation.none", "Displays each force in a step and holds it.")
      .details("F(t) = F_t from the time the forecast arrives. The node ignores the predicted force.")
      .realtime_safe()
      .input("forecast", &NoInterpolation::forecast, {.doc = "the force to display", .trigger = Trigger::yes})
      .output("segment", &NoInterpolation::segment, "a constant")
      .role(Role::interpolation)
      .info();
}

NoInterpolation::NoInterpolation(const Params&, const NodeContext&) {}

void NoInterpolation::step(StepContext& context) {
  const Stamped<Forecast>* newest = forecast.latest();
  if (newest == nullptr) return;
  segment.send(newest->stamp.valid, constant_segment(context.now(), newest->value.current_D_W));
}

}  // namespace tactor
