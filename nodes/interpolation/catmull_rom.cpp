#include "nodes/interpolation/catmull_rom.hpp"

#include "nodes/interpolation/forecast_curve.hpp"
#include "nodes/interpolation/not_finite.hpp"

namespace tactor {

NodeInfo CatmullRom::declare() {
  return Declare<CatmullRom>("interpolation.catmull_rom", "A Catmull-Rom spline through physics and predicted forces.")
      .details(
          "Each forecast gives one segment, one period T long, between the middle two of four points P_0 to P_3 that "
          "stand for forces one period apart: C(u) = (2 P_1 + (P_2 - P_0) u + (2 P_0 - 5 P_1 + 4 P_2 - P_3) u^2 + (3 "
          "P_1 - P_0 - 3 P_2 + P_3) u^3) / 2. `start: predicted` takes F_t and the three predicted steps. It shows the "
          "force expected from now on if a result arrives one period after its stamp. `start: current` takes F_{t-1}, "
          "F_t and two steps. It shows the force a period late and more accurately. Missing steps repeat the last one. "
          "If the forecasts are right, neighbouring segments join with C1. Each join jumps by what the forecast before "
          "was wrong by, and by what an early one leaves out. A late end is held.\nSource: Catmull and Rom, A class of "
          "local interpolating splines (1974).")
      .realtime_safe()
      .input("forecast", &CatmullRom::forecast,
             {.doc = "the physics force and the predicted forces", .trigger = Trigger::yes})
      .output("segment", &CatmullRom::segment, "a segment over one period")
      .choice("start", &Params::start, {{"current", Start::current}, {"predicted", Start::predicted}},
              std::optional(Start::predicted),
              "the force at which the segment starts: F_t (current), or the first predicted step (predicted)")
      .cheaper("interpolation.linear")
      .cheaper("interpolation.none")
      .role(Role::interpolation)
      .info();
}

void CatmullRom::step(StepContext& context) {
  const Stamped<Forecast>* newest = forecast.latest();
  if (newest == nullptr) return;
  const Time now = context.now();
  const Forecast& f = newest->value;
  if (const auto fault = segment_if_not_finite(now, f)) return segment.send(newest->stamp.valid, *fault);
  if (!any_) before_ = f.current_D_W;
  any_ = true;
  const auto step = [&f](int i) {
    return f.predicted_D_W[static_cast<std::size_t>(std::min(i, std::clamp(f.count, 1, Forecast::capacity)) - 1)];
  };
  const std::array<Wrench, 4> P = start_ == Start::predicted
                                      ? std::array<Wrench, 4>{f.current_D_W, step(1), step(2), step(3)}
                                      : std::array<Wrench, 4>{before_, f.current_D_W, step(1), step(2)};
  before_ = f.current_D_W;
  const Duration period = period_of(f);
  const double per_second = 0.5 / period.seconds();
  segment.send(newest->stamp.valid, cubic_between(now, period, {P[1], per_second * (P[2] - P[0]), {}},
                                                  {P[2], per_second * (P[3] - P[1]), {}}));
}

}  // namespace tactor
