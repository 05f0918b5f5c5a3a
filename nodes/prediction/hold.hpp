// The predictor that expects no change: the baseline every other one is compared with.
#pragma once

#include "nodes/prediction/predictor.hpp"

namespace tactor {

/// prediction.hold: F_{t+1|t} = F_t.
class HoldPredictor final : public Predictor {
 public:
  using Params = PredictorParams;
  HoldPredictor(const Params& params, const NodeContext& context) : Predictor(params, context) {}
  static NodeInfo declare();

 private:
  void take(const Stamped<Wrench>&) override {}
  Outcome predict(Duration, std::span<Wrench>) override { return Outcome::predicted; }
};

}  // namespace tactor
