#include "nodes/interpolation/hermite.hpp"

#include <algorithm>

#include "nodes/interpolation/not_finite.hpp"

namespace tactor {

namespace {

// A slope over one period is that much more over the next at most.
constexpr double most_growth = 1.5;

constexpr const char* in_common =
    " of the forecast's curve one period after now. The curve goes through F_t at its stamp and the predicted steps at "
    "stamp + i T; `shape` says how. With two or more steps the segment is on time. With one step, it ends at the value "
    "held for a result that has been under way for a period. If the next forecast comes early, its segment continues "
    "from the displayed curve. If it is late, the end is held and the next segment starts from it at rest. The slope "
    "jumps there. It also jumps if the period grows by more than half, say from T0 to T: a slope that was small over "
    "T0 would overshoot far over T, so it is scaled by 1.5 T0 / T, and the curvature by the square of that. For "
    "forecasts that jump from bound to bound at any period, the displayed force stays within 2.5 times the bound "
    "(measured; no closed form).";

/// `from` as a segment of `length` can take it, where the segment that is displayed has `before`.
ForceState entered(ForceState from, Duration before, Duration length) {
  const double share = std::min(1.0, most_growth * before.seconds() / length.seconds());
  from.rate = share * from.rate;
  from.curvature = (share * share) * from.curvature;
  return from;
}

template <class N>
NodeInfo declare_hermite(const char* type, const char* summary, const std::string& ends) {
  return Declare<N>(type, summary)
      .details("One segment for each forecast: " + ends + in_common)
      .realtime_safe()
      .input("forecast", static_cast<Input<Forecast> N::*>(&N::forecast),
             {.doc = "the physics force and the predicted forces", .trigger = Trigger::yes})
      .output("segment", static_cast<Output<ForceSegment> N::*>(&N::segment), "a segment over one period")
      .choice("shape", &N::Params::shape, {{"linear", CurveShape::linear}, {"cubic", CurveShape::cubic}},
              std::optional(CurveShape::cubic),
              "the curve between the steps of the forecast: straight lines, or the cubic through the nearest four")
      .cheaper("interpolation.linear")
      .cheaper("interpolation.none")
      .role(Role::interpolation)
      .metric("interpolation.late", "1", "forecasts that came after the end of the segment", Better::lower,
              &Hermite::late)
      .metric("interpolation.early", "1", "forecasts that came before the end of the segment", Better::neither,
              &Hermite::early)
      .info();
}

}  // namespace

NodeInfo HermiteCubic::declare() {
  return declare_hermite<HermiteCubic>("interpolation.hermite_cubic",
                                       "A cubic from the displayed force to the one expected a period from now.",
                                       "the cubic from the displayed value and slope to the value and slope");
}

NodeInfo HermiteQuintic::declare() {
  return declare_hermite<HermiteQuintic>("interpolation.hermite_quintic",
                                         "A quintic from the displayed force to the one expected a period from now.",
                                         "the quintic from the displayed value, slope and curvature to those");
}

void Hermite::step(StepContext& context) {
  const Stamped<Forecast>* newest = forecast.latest();
  if (newest == nullptr) return;
  const Time now = context.now();
  if (const auto fault = segment_if_not_finite(now, newest->value)) return segment.send(newest->stamp.valid, *fault);
  if (any_ && now > shown_.end) ++late_;
  if (any_ && now < shown_.end) ++early_;
  any_ = true;
  const Duration period = period_of(newest->value);
  const ForecastCurve curve(*newest, shape_);
  const ForceState to = curve.at(now + period);
  shown_ = between_(now, period, entered(displayed(shown_, now), shown_.end - shown_.begin, period), to);
  segment.send(newest->stamp.valid, shown_);
}

}  // namespace tactor
