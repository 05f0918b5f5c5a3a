// From what is displayed to what is expected one period from now, by cubic or quintic Hermite segments.
#pragma once

#include "framework/core/messages.hpp"
#include "framework/node/declare.hpp"
#include "nodes/interpolation/forecast_curve.hpp"

namespace tactor {

/// interpolation.hermite_cubic and interpolation.hermite_quintic: one segment for each forecast, from the displayed
/// value and slope (and curvature) when it arrives to those of the forecast's curve (ForecastCurve) one period later.
class Hermite : public Node {
 public:
  struct Params {
    CurveShape shape = CurveShape::cubic;
  };
  void step(StepContext& context) override;
  /// Forecasts that came after the end of the segment, and before it.
  [[nodiscard]] std::int64_t late() const { return late_; }
  [[nodiscard]] std::int64_t early() const { return early_; }

  Input<Forecast> forecast;
  Output<ForceSegment> segment;

 protected:
  using Between = ForceSegment (*)(Time begin, Duration length, const ForceState& from, const ForceState& to);
  Hermite(const Params& params, Between between) : shape_(params.shape), between_(between) {}

 private:
  CurveShape shape_;
  Between between_;
  ForceSegment shown_;
  bool any_ = false;
  std::int64_t late_ = 0, early_ = 0;
};

/// Value and slope at both ends: C1.
class HermiteCubic final : public Hermite {
 public:
  using Params = Hermite::Params;
  HermiteCubic(const Params& params, const NodeContext&) : Hermite(params, cubic_between) {}
  static NodeInfo declare();
};

/// Value, slope and curvature at both ends: C2.
class HermiteQuintic final : public Hermite {
 public:
  using Params = Hermite::Params;
  HermiteQuintic(const Params& params, const NodeContext&) : Hermite(params, quintic_between) {}
  static NodeInfo declare();
};

}  // namespace tactor
