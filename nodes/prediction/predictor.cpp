#include "nodes/prediction/predictor.hpp"

#include <algorithm>

namespace tactor {

void Predictor::step(StepContext& context) {
  const bool first = !taken_;
  read_inputs();
  Stamped<Wrench> sample;
  bool any = false;
  bool usable = false;
  while (samples_.next(force, sample)) {
    any = true;
    usable = guard_.accept(sample.value);
    period_.update(sample.stamp.valid);
    if (!usable) continue;
    take(sample);
    taken_ = sample.stamp.valid;
  }
  if (!any) return;
  const Duration horizon = period_.value();
  Forecast f;
  f.current_D_W = sample.value;
  f.horizon = horizon.seconds();
  f.count = steps_;
  const std::span<Wrench> predicted = std::span(f.predicted_D_W).first(static_cast<std::size_t>(steps_));
  std::fill(predicted.begin(), predicted.end(), sample.value);
  bool held = !usable;
  if (usable) {
    const Outcome outcome = predict(horizon, predicted);
    if (outcome == Outcome::warm_up) guard_.count_warm_up();
    if (outcome == Outcome::held) guard_.count_held();
    held = outcome != Outcome::predicted;
  }
  // One that is warm with the first sample is so from the start.
  if (!warm_since_ && taken_ && is_warm()) warm_since_ = first ? Time{} : context.now();
  const bool repaired = guard_.repair(f.current_D_W, predicted);
  f.fallback = held || repaired ? 1 : 0;
  // What is held although samples come is as old as the last that could be used, and whoever shows it must see that.
  forecast.send(taken_.value_or(sample.stamp.valid), f);
}

}  // namespace tactor
