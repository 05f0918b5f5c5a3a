#include "nodes/prediction/engine_resimulation.hpp"

#include <algorithm>
#include <cmath>

#include "framework/core/clock.hpp"

namespace tactor {

void EngineResimulation::step(Input<EngineState>& result, Input<DeviceState>& device, Output<EngineState>& model) {
  track_.take(device);
  const Stamped<EngineState>* newest = result.latest();
  if (newest == nullptr || track_.count() == 0) return;
  refused_.count(take_result(*newest, model));
}

/// The trees that the rollout can step within its budget until the next result.
Trees EngineResimulation::trees_to_move(const Stamped<EngineState>& result) {
  const std::size_t since = track_.after(result.value.time);
  const double age = std::max(0.0, (track_.newest().stamp.valid - result.value.time).seconds());
  if (since < track_.count()) tick_ = age / static_cast<double>(track_.count() - since);
  // The first result comes alone; the next takes about as long as it did.
  const double interval = results_ > 0 ? (result.stamp.valid - newest_result_).seconds() : age;
  const double steps = std::max(1.0, std::ceil(tick_ / motion_.substep() - 1e-6));
  return motion_.near_trees(result.value, track_.newest().value, age + std::max(0.0, interval),
                            budget_.tick / steps / cost_ratio_.value_or(1));
}

void EngineResimulation::note_cost(double seconds, std::int64_t steps, Trees moving) {
  const double modelled = static_cast<double>(steps) * motion_.engine().step_cost(moving);
  if (!budget_.measured || modelled <= 0) return;
  constexpr double share_of_new = 0.1, least = 0.01, most = 100;
  const double ratio = std::clamp(seconds / modelled, least, most);
  cost_ratio_ = cost_ratio_ ? *cost_ratio_ + share_of_new * (ratio - *cost_ratio_) : ratio;
}

/// Sends the result's state, brought on to the newest sample; or why not.
RefusalReason EngineResimulation::take_result(const Stamped<EngineState>& result, Output<EngineState>& model) {
  // What the handle did between a result and the samples that are known would be guessed.
  if (track_.first() > 0 && result.value.time < track_[track_.first()].stamp.valid) return RefusalReason::late;
  const Trees moving = trees_to_move(result);
  if (const RefusalReason why = motion_.restart(result.value, moving); why != RefusalReason::none) return why;
  const std::int64_t steps_before = motion_.steps();
  const double begin = budget_.measured ? clock_seconds(CLOCK_THREAD_CPUTIME_ID) : 0;
  for (std::size_t k = track_.after(motion_.time()); k < track_.count(); ++k) {
    // The display goes on with the model before.
    if (!motion_.advance(track_[k], result.value.coupling)) return RefusalReason::unsolved;
  }
  if (budget_.measured) {
    note_cost(clock_seconds(CLOCK_THREAD_CPUTIME_ID) - begin, motion_.steps() - steps_before, moving);
  }
  const std::optional<EngineState> sent = motion_.state(*numbers_, &result.value);
  if (!sent) return RefusalReason::incomplete;
  model.send(result.stamp.valid, *sent);
  newest_result_ = result.stamp.valid;
  ++results_;
  return RefusalReason::none;
}

}  // namespace tactor
