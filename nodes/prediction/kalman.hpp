// The predictor that filters the force and its rate, and goes on from them.
#pragma once

#include "nodes/prediction/predictor.hpp"
#include "nodes/prediction/trend_filter.hpp"

namespace tactor {

/// prediction.kalman: F_{t+1|t} = F + T F' (+ T^2/2 F''), T the estimated period, with F, F' and F'' from a Kalman
/// filter (see TrendFilter) that takes the samples at the times of their stamps.
class KalmanPredictor final : public Predictor {
 public:
  struct Params : PredictorParams {
    Trend model = Trend::constant_velocity;
    double force_noise = 0.02;
    double force_departure = 0.04;
    double torque_noise = 0.0005;
    double torque_departure = 0.001;
    double gate = 10;
  };
  KalmanPredictor(const Params& params, const NodeContext& context);
  static NodeInfo declare();

 private:
  void take(const Stamped<Wrench>& sample) override;
  Outcome predict(Duration horizon, std::span<Wrench> predicted) override;

  TrendFilter force_;
  TrendFilter torque_;
  Time last_;
  std::int64_t seen_ = 0;
};

}  // namespace tactor
