// The predictor that goes on along the line through the last two physics samples.
#pragma once

#include "nodes/prediction/predictor.hpp"

namespace tactor {

/// prediction.linear: F_{t+1|t} = F_t + (F_t - F_{t-1}) T / (t_t - t_{t-1}), T the estimated period, times by stamps.
class LinearPredictor final : public Predictor {
 public:
  using Params = PredictorParams;
  LinearPredictor(const Params& params, const NodeContext& context) : Predictor(params, context) {}
  static NodeInfo declare();

 private:
  void take(const Stamped<Wrench>& sample) override;
  Outcome predict(Duration horizon, std::span<Wrench> predicted) override;

  Stamped<Wrench> last_;
  Wrench rate_;  // N/s and N m/s, over the last interval
  int seen_ = 0;
};

}  // namespace tactor
