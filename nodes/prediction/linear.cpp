#include "nodes/prediction/linear.hpp"

#include <algorithm>

namespace tactor {

NodeInfo LinearPredictor::declare() {
  Declare<LinearPredictor> node("prediction.linear", "Extrapolates the last two forces in time.");
  node.details(
      "F_{t+1|t} = F_t + (F_t - F_{t-1}) T / (t_t - t_{t-1}), with the stamps of the samples as their times and T the "
      "estimated physics period, so an uneven period is taken into account. After a sample that is not finite, and "
      "before the second good one, it holds.");
  return declare_predictor(node).info();
}

LinearPredictor::LinearPredictor(const Params& params, const NodeContext& context)
    : guard_(params, context.torque), period_(params) {}

void LinearPredictor::step(StepContext&) {
  Stamped<Wrench> sample;
  bool any = false;
  bool usable = false;
  while (samples_.next(force, sample)) {
    any = true;
    usable = guard_.accept(sample.value);
    period_.update(sample.stamp.valid);
    if (!usable) continue;
    const double interval = (sample.stamp.valid - last_.stamp.valid).seconds();
    rate_ = seen_ > 0 && interval > 0 ? (1.0 / interval) * (sample.value - last_.value) : Wrench{};
    last_ = sample;
    seen_ = std::min(seen_ + 1, 2);
  }
  if (!any) return;
  Forecast f{sample.value, sample.value, period_.value().seconds()};
  if (usable) {
    if (seen_ < 2) guard_.count_warm_up();
    f.predicted_D_W = f.current_D_W + f.horizon * rate_;
  }
  const bool mended = guard_.mend(f.current_D_W, f.predicted_D_W);
  f.fallback = !usable || mended || seen_ < 2 ? 1 : 0;
  forecast.send(sample.stamp.valid, f);
}

}  // namespace tactor
