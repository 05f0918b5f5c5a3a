// The force of a rollout as the segments that a device is shown.
#pragma once

#include "framework/core/messages.hpp"
#include "framework/node/port.hpp"
#include "nodes/interpolation/blended_force.hpp"
#include "nodes/interpolation/model_intake.hpp"

namespace tactor {

/// Blends the force that a rollout aims at, and sends it tick by tick. A segment tells the device for how long the
/// physics result behind it is trusted.
class RolloutDisplay {
 public:
  /// What a tick aims at.
  struct Aim {
    ForceState force;        ///< now
    bool changed = false;    ///< it is not the force of the tick before, carried on
    bool corrected = false;  ///< a new model has come, and is continued
    Duration trust_time;     ///< age up to which a result is trusted
    Time valid;              ///< of the physics result behind the force, as which the segment is stamped
  };

  /// `tick`: length of a segment; `blend_time`: time constant of the two equal poles with which a change decays.
  RolloutDisplay(Duration tick, Duration blend_time) : tick_(tick), blended_(tick, blend_time) {}

  /// Sends the segment of the tick that begins at `now`. The force changes no faster than from zero to the limits of
  /// `coupling` in a tick. False if the force is not finite: then the segment holds it, so that the device's gate goes
  /// into fault, and the curve stays as it was.
  bool show(Time now, const Aim& aim, const CouplingParameters& coupling, ModelIntake& intake,
            Output<ForceSegment>& segment);
  [[nodiscard]] Duration tick() const { return tick_; }
  /// N, RMS of the jumps of the force at new models.
  [[nodiscard]] double correction_rms() const { return blended_.correction_rms(); }

 private:
  Duration tick_;
  BlendedForce blended_;
};

}  // namespace tactor
