// Uniform cubic B-splines through the physics forces and the predicted one.
#pragma once

#include <array>

#include "framework/core/messages.hpp"
#include "framework/node/period_parameters.hpp"

namespace tactor {

/// The coefficients of 1, u, u^2, u^3, 0 <= u <= 1, of the uniform cubic B-spline segment on the control points
/// P_0..P_3: B(u) = ((1-u)^3 P_0 + (3u^3 - 6u^2 + 4) P_1 + (-3u^3 + 3u^2 + 3u + 1) P_2 + u^3 P_3) / 6. Source: Hou and
/// Sourina, "Real-time Adaptive Prediction Method for Smooth Haptic Rendering", its B-spline equation.
std::array<Wrench, 6> bspline_cubic(const std::array<Wrench, 4>& control);

/// The B-spline segment towards the control point P_3 that goes on from a curve with C2: `value`, and `slope` and
/// `curvature` per knot interval (multiplied by T and T^2). These three are the control points P_0, P_1, P_2 of
/// exactly one uniform B-spline, P_1 = value - curvature / 6, P_2 - P_0 = 2 slope, P_0 - 2 P_1 + P_2 = curvature.
std::array<Wrench, 6> bspline_continued(const Wrench& value, const Wrench& slope, const Wrench& curvature,
                                        const Wrench& next);

/// interpolation.bspline: one segment for each forecast, as long as the estimated physics period.
class BSpline final : public Node {
 public:
  enum class ControlPoints { mixed, predicted };
  enum class Join { paper, hermite, continuous };
  struct Params : PeriodOptions {
    ControlPoints control_points = ControlPoints::mixed;
    Join join = Join::hermite;
  };
  BSpline(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  void step(StepContext& context) override;

  Input<Forecast> forecast;
  Output<ForceSegment> segment;

 private:
  [[nodiscard]] ForceSegment as_printed(const Forecast& f, Time begin, Duration length);

  Params params_;
  bool torque_;
  PeriodEstimate period_;
  ForceSegment curve_;
  std::array<Wrench, 4> control_{};  // the last control points, newest last
  bool any_ = false;
  std::int64_t late_ = 0, early_ = 0;
};

}  // namespace tactor
