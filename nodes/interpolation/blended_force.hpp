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
///   w = sum g a.d / sum g d.d,   g = 1 / (|a|^2 + |d|^2),   each term fading over 50 ms,
/// the least-squares estimate in which no sample counts for more than another; for force and torque apart. So a force
/// is carried on where velocities are well known and surfaces even, and hardly where the encoder's steps or the texture
/// make every change a surprise. From sample to sample the shown rate changes by no more
/// than a quarter of the larger of two: the largest change of the force per interval, which fades over 1 s, and the
/// rate shown before. So a change that comes as a surprise is displayed a tick late, and what is caught up makes no
/// step that is much larger than those of the force itself. Carried on for two ticks at most, because samples that stay
/// out are no reason to go on for ever. Within the device's limits.
class CarriedForce {
 public:
  CarriedForce(Duration tick, bool torque) : tick_(tick), torque_(torque) {}

  ForceState at(Time now, const LocalRollout& rollout, const Twist& a_D);
  /// From where another rollout has tool and handle at the sample's time, with the tool's acceleration.
  ForceState at(Time now, Time sampled, const PhysicsState& state, const CouplingParameters& coupling, const Twist& a_T,
                const Twist& a_D);

 private:
  /// What is foretold of a force, or of a torque.
  class Foretold {
   public:
    /// The rate to go on with at a sample `interval` s after the last, where value and rate are these.
    Vec3 rate(const Vec3& value, const Vec3& rate, double interval);

   private:
    // As if one change had come true.
    double told_ = 1, square_ = 1;
    Vec3 last_, last_rate_, shown_rate_;
    double largest_ = 0;  // change, fading
    bool started_ = false;
  };
  Duration tick_;
  bool torque_;
  Foretold force_, turning_;
  Time last_;    // of the samples
  Wrench rate_;  // N/s and N m/s, at that one
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
  /// Counts the difference of what is shown from what is aimed at, at the begin of the last tick.
  void count_correction();
  /// N, RMS of the differences counted.
  [[nodiscard]] double correction_rms() const;

 private:
  Duration tick_;
  double tau_;  // s
  bool shown_any_ = false;
  ForceState difference_;
  ForceSegment shown_;
  std::int64_t corrections_ = 0;
  double correction_sum_ = 0;  // N^2
};

/// Where `aim` is one tick later if it keeps its rate, within the device's limits.
ForceState one_tick_later(const ForceState& aim, Duration tick, const CouplingParameters& coupling);

}  // namespace tactor
