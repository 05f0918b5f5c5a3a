// The force that a device is shown by nodes that step the tool in the lane: the coupling's, carried on to the tick at
// which it is shown, and blended where what is aimed at changes.
#pragma once

#include "framework/core/messages.hpp"
#include "nodes/interpolation/force_state.hpp"
#include "nodes/physics/mechanics/local_rollout.hpp"

namespace tactor {

/// Shortened to the device's limits; `share` of them.
Wrench limited(const Wrench& wrench, const CouplingParameters& coupling, double share = 1);

/// The coupling's wrench at the time of display and its rate, from where the rollout is, at t_s:
///   F(t) = F + w F' (t - t_s),   F' = -k (v_D - v_T) - b (a_D - a_T),
/// with a_D the handle's acceleration and a_T the tool's over its last step. The weight w is the share of the foretold
/// changes that came true, 0 <= w <= 1: over the last samples, with d = F' dt foretold from one to the next and a the
/// change that there was,
///   w = sum a.d / sum d.d,   each term fading over 50 ms,
/// the least-squares estimate; for force and torque apart. So a force is carried on where velocities are well known and
/// surfaces even, and hardly where the encoder's steps or the texture make every change a surprise.
/// Carried on for two ticks at most, because samples that stay out are no reason to go on for ever. Within the device's
/// limits.
class CarriedForce {
 public:
  CarriedForce(Duration tick, bool torque) : tick_(tick), torque_(torque) {}

  ForceState at(Time now, const LocalRollout& rollout, const Twist& a_D);

 private:
  struct Weight {
    double told, square;
    void take(const Vec3& change, const Vec3& foretold, double kept);
    [[nodiscard]] double value() const;
  };
  void take(const ForceState& state, Time time);

  Duration tick_;
  bool torque_;
  // As if a small change had come true.
  Weight force_{1e-6, 1e-6};            // N^2
  Weight torque_weight_{1e-12, 1e-12};  // N^2 m^2
  bool started_ = false;
  ForceState last_;  // at the sample before
  Time last_time_;
};

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
