// The forecast at the device's own time, with what each new one changes blended out.
#pragma once

#include "framework/core/messages.hpp"
#include "framework/node/declare.hpp"
#include "nodes/interpolation/forecast_curve.hpp"

namespace tactor {

/// interpolation.blend: F(t) = G(t) + e(t) with G the newest forecast as a curve (ForecastCurve) evaluated at the time
/// of display, and e = F - G at each step, the displayed force against it, which decays over the tick that follows. So
/// nothing of F jumps when a forecast arrives, early, late or on time, and F meets G within a few `blend_time`.
class Blend final : public Node {
 public:
  enum class Continuity { c1, c2 };
  struct Params {
    Duration blend_time;
    CurveShape shape = CurveShape::linear;
    Continuity continuity = Continuity::c1;
    double rate = 0;
  };
  Blend(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  void step(StepContext& context) override;
  void tune(const Params& params) { params_.blend_time = params.blend_time; }

  Input<Forecast> forecast;
  Output<ForceSegment> segment;

 private:
  Params params_;
  Duration tick_;
  ForceSegment shown_;
  std::int64_t late_ = 0;
};

}  // namespace tactor
