// The predictor that goes on along the line through the last two physics samples.
#pragma once

#include "framework/node/new_messages.hpp"
#include "nodes/prediction/parameters.hpp"

namespace tactor {

/// prediction.linear: F_{t+1|t} = F_t + (F_t - F_{t-1}) T / (t_t - t_{t-1}), T the estimated period, times by stamps.
class LinearPredictor final : public Node {
 public:
  using Params = PredictorParams;
  LinearPredictor(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  void step(StepContext& context) override;
  void report(Report& report) const override { guard_.report(report); }

  Input<Wrench> force;
  Output<Forecast> forecast;

 private:
  ForecastGuard guard_;
  PeriodEstimate period_;
  NewMessages<Wrench> samples_;
  Stamped<Wrench> last_;
  Wrench rate_;  // N/s and N m/s, over the last interval
  int seen_ = 0;
};

}  // namespace tactor
