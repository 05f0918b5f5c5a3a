#include "nodes/prediction/hold.hpp"

namespace tactor {

NodeInfo HoldPredictor::declare() {
  Declare<HoldPredictor> node("prediction.hold", "Expects that the force stays as it is.");
  node.details(
      "F_{t+1|t} = F_t for force and torque. The baseline: what a device does that repeats the last physics force. A "
      "sample that is not finite is replaced by the last good one.");
  return declare_predictor(node).info();
}

HoldPredictor::HoldPredictor(const Params& params, const NodeContext& context)
    : guard_(params, context.torque), period_(params) {}

void HoldPredictor::step(StepContext&) {
  Stamped<Wrench> sample;
  bool any = false;
  bool fallback = false;
  while (samples_.next(force, sample)) {
    any = true;
    fallback = !guard_.accept(sample.value);
    period_.update(sample.stamp.valid);
  }
  if (!any) return;
  Forecast f{sample.value, sample.value, period_.value().seconds()};
  f.fallback = (guard_.mend(f.current_D_W, f.predicted_D_W) || fallback) ? 1 : 0;
  forecast.send(sample.stamp.valid, f);
}

}  // namespace tactor
