// A forecast as a curve over time.
#pragma once

#include <algorithm>

#include "nodes/interpolation/force_state.hpp"

namespace tactor {

/// The physics period that a forecast counts in, above zero.
inline Duration period_of(const Forecast& forecast) {
  return std::max(Duration::from_seconds(forecast.horizon), Duration{1});
}

/// What lies between the knots of a forecast.
enum class CurveShape {
  linear,  ///< straight lines
  cubic,   ///< on each interval the polynomial through the nearest four knots (all of them where there are fewer)
};

/// The curve through the current force at the stamp and the steps at stamp + i horizon, i = 1 .. count: continuous, its
/// rate and curvature those of the piece that begins at a knot. Held, at rest, before the stamp and from the last step
/// on, so that a late forecast is never carried further than it was predicted. A force that is a polynomial of degree
/// min(3, count) between stamp and last step is reproduced by `cubic` to rounding.
class ForecastCurve {
 public:
  ForecastCurve(const Stamped<Forecast>& forecast, CurveShape shape)
      : begin_(forecast.stamp.valid),
        forecast_(forecast.value),
        count_(std::clamp<std::int32_t>(forecast.value.count, 1, Forecast::capacity)),
        degree_(shape == CurveShape::linear ? 1 : std::min(3, count_)) {}

  [[nodiscard]] ForceState at(Time t) const {
    const double h = forecast_.horizon;
    // In intervals since the stamp; written so that a horizon of zero holds the last step.
    const double u = t <= begin_ ? 0.0 : (t - begin_).seconds() / h;
    if (!(u < count_)) return {knot(count_), {}, {}};
    if (t < begin_) return {knot(0), {}, {}};
    const int first = std::clamp(static_cast<int>(u) - (degree_ - 1) / 2, 0, count_ - degree_);
    const double x = u - first;
    // Newton's forward differences d1, d2, d3 of the knots from `first` on.
    const Wrench y0 = knot(first);
    const Wrench y1 = knot(first + 1);
    const Wrench d1 = y1 - y0;
    ForceState s{y0 + x * d1, d1, {}};
    if (degree_ > 1) {
      const Wrench y2 = knot(first + 2);
      const Wrench d2 = y2 - 2.0 * y1 + y0;
      s.value = s.value + (0.5 * x * (x - 1)) * d2;
      s.rate = s.rate + (x - 0.5) * d2;
      s.curvature = d2;
      if (degree_ > 2) {
        const Wrench d3 = knot(first + 3) - 3.0 * (y2 - y1) - y0;
        s.value = s.value + (x * (x - 1) * (x - 2) / 6.0) * d3;
        s.rate = s.rate + (0.5 * x * x - x + 1.0 / 3.0) * d3;
        s.curvature = s.curvature + (x - 1) * d3;
      }
    }
    return {s.value, (1.0 / h) * s.rate, (1.0 / (h * h)) * s.curvature};
  }

  /// True where t is later than the last step, whose value is held.
  [[nodiscard]] bool is_over(Time t) const { return !(t <= begin_ + period_of(forecast_) * count_); }

 private:
  [[nodiscard]] const Wrench& knot(int i) const {
    return i == 0 ? forecast_.current_D_W : forecast_.predicted_D_W[static_cast<std::size_t>(i - 1)];
  }

  Time begin_;
  Forecast forecast_;
  std::int32_t count_;
  std::int32_t degree_;
};

}  // namespace tactor
