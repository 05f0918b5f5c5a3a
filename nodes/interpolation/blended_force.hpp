// The force that a device is shown by nodes that step the tool in the lane: the coupling's, carried on to the tick at
// which it is shown, and blended where what is aimed at changes.
#pragma once

#include "framework/core/messages.hpp"
#include "nodes/interpolation/force_state.hpp"
#include "nodes/physics/mechanics/local_rollout.hpp"

namespace tactor {

/// Shortened to the device's limits; `share` of them.
Wrench limited(const Wrench& wrench, const CouplingParameters& coupling, double share = 1);

/// The coupling's wrench at `now` and its rate, from where the rollout is, at t_s:
///   F(t) = F + F' (t - t_s),   F' = -k (v_D - v_T) - b (a_D - a_T),
/// with `a_D` the handle's acceleration and a_T the tool's over its last step. Carried on for two ticks at most,
/// because samples that stay out are no reason to go on for ever. Within the device's limits.
ForceState carried_on(const LocalRollout& rollout, const Twist& a_D, Time now, Duration tick, bool torque);

/// The curve that is shown from tick to tick. It starts at what is aimed at. Where the aim changes, what is shown stays
/// as it is, and the difference e decays as tau^2 e'' + 2 tau e' + e = 0, from a rate between 0 and -e / tau, so that
/// it neither grows nor swings to the other side.
class BlendedForce {
 public:
  BlendedForce(Duration tick, Duration tau) : tick_(tick), tau_(tau.seconds()) {}

  /// The segment of the tick that begins at `now`: towards `aim` now and `later` at the tick's end. `changed`: the aim
  /// is not the one before, carried on.
  const ForceSegment& go_on(Time now, const ForceState& aim, const ForceState& later, bool changed);
  /// Of what is shown from what is aimed at, at the begin of the last tick.
  [[nodiscard]] const ForceState& difference() const { return difference_; }

 private:
  Duration tick_;
  double tau_;  // s
  bool shown_any_ = false;
  ForceState difference_;
  ForceSegment shown_;
};

/// Where `aim` is one tick later if it keeps its rate, within the device's limits.
ForceState one_tick_later(const ForceState& aim, Duration tick, const CouplingParameters& coupling);

}  // namespace tactor
