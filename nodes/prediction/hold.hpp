// The predictor that expects no change: the baseline every other one is judged against.
#pragma once

#include "framework/node/new_messages.hpp"
#include "nodes/prediction/parameters.hpp"

namespace tactor {

/// prediction.hold: F_{t+1|t} = F_t.
class HoldPredictor final : public Node {
 public:
  using Params = PredictorParams;
  HoldPredictor(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  void step(StepContext& context) override;
  void report(Report& report) const override { guard_.report(report); }

  Input<Wrench> force;
  Output<Forecast> forecast;

 private:
  ForecastGuard guard_;
  PeriodEstimate period_;
  NewMessages<Wrench> samples_;
};

}  // namespace tactor
