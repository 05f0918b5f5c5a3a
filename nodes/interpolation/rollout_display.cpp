#include "nodes/interpolation/rollout_display.hpp"

#include <algorithm>

#include "nodes/interpolation/not_finite.hpp"

namespace tactor {

bool RolloutDisplay::show(Time now, const Aim& aim, const CouplingParameters& coupling, ModelIntake& intake,
                          Output<ForceSegment>& segment) {
  ForceState to = aim.force;
  if (const auto fault = segment_if_not_finite(now, {to.value, to.rate})) {
    segment.send(aim.valid, *fault);
    return false;
  }
  // A sample that is finite and yet absurd would else be blended out for long.
  to.rate = limited(to.rate, coupling, 1 / tick_.seconds());
  ForceSegment shown = blended_.go_on(now, to, one_tick_later(to, tick_, coupling), aim.changed);
  // Zero would say nothing.
  shown.trust_time = std::max(aim.trust_time, Duration{1});
  if (intake.running() && aim.corrected) blended_.count_correction();
  intake.start();
  segment.send(aim.valid, shown);
  return true;
}

}  // namespace tactor
