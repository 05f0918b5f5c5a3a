// Linear interpolation from the displayed force to the predicted one.
#pragma once

#include "framework/core/messages.hpp"
#include "framework/node/period_parameters.hpp"

namespace tactor {

/// interpolation.linear: F(t) = F(t_0) + (F_{t+1|t} - F(t_0)) (t - t_0) / T from the arrival t_0 on, T the estimated
/// physics period; held where the next forecast is late. Continuous (C0) whenever the next one comes.
class LinearInterpolation final : public Node {
 public:
  struct Params : PeriodOptions {};
  LinearInterpolation(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  void step(StepContext& context) override;

  Input<Forecast> forecast;
  Output<ForceSegment> segment;

 private:
  PeriodEstimate period_;
  ForceSegment curve_;
};

}  // namespace tactor
