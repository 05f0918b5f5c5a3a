// interpolation.direct: steps the scene once per sample of the handle, so that nothing need be predicted.
#pragma once

#include <limits>

#include "framework/core/messages.hpp"
#include "framework/core/refusals.hpp"
#include "framework/node/declare.hpp"
#include "nodes/interpolation/blended_force.hpp"
#include "nodes/interpolation/scene_start.hpp"
#include "nodes/interpolation/stepped_scene.hpp"
#include "nodes/physics/contact/surface_contacts.hpp"
#include "nodes/physics/mechanics/handle_track.hpp"

namespace tactor {

/// Steps all moving bodies of the scene at each sample of the handle, with contacts found where the bodies are, and
/// displays the coupling's wrench carried on to the tick at which the device shows it (see CarriedForce).
///
/// It starts from the first result of `bodies`, goes through the samples since, and then needs no result any more.
/// Where a step does not fit it displays the segment of `otherwise`. A step does not fit where its contact query needs
/// more than `most_work`, where it does not converge, or where its force is not finite. With the next result of
/// `bodies` it tries again. All changes are blended (see BlendedForce).
///
/// The segment is stamped as the newest sample stepped to, or as that of `otherwise`. So after a fall-back no segment
/// is fresh to the device's gate until physics has passed the last sample stepped to: give `stale_after` two intervals
/// of physics at least.
class Direct final : public Node, public Refusing {
 public:
  struct Params : SurfaceOptions {
    Duration blend_time;
    std::int32_t iterations = 0;
    double stick_velocity = 0;  // m/s
    Integrator integrator = Integrator::implicit_euler;
    double rate = 0;
  };
  Direct(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  void step(StepContext& context) override;
  [[nodiscard]] const Refusals& refusals() const override { return start_.refusals(); }

  Input<DeviceState> device;
  Input<CouplingParameters> coupling;
  Input<BodyStates> bodies;
  Input<ForceSegment> otherwise;
  Output<ForceSegment> segment;

 private:
  struct Aim {
    ForceState now, later;  // `later` is a tick later
    Time valid;
    Duration trust_time;     // of the segment that is displayed where a step does not fit
    bool changed = false;    // it is not the one before, carried on
    bool of_bodies = false;  // it is the coupling's wrench
  };

  void begin(Time now);
  void go_on();
  void fall_back();
  /// The bodies have been through all samples, and stepped to the newest.
  [[nodiscard]] bool is_up_to_date() const { return stepping_ && !catching_up_; }
  [[nodiscard]] bool aim_at_bodies(Time now);
  [[nodiscard]] bool aim_at_otherwise(Time now);

  bool torque_;
  Duration tick_;
  SteppedScene scene_;
  CarriedForce carried_;
  BlendedForce blended_;
  HandleTrack<256> track_;
  std::size_t advanced_ = 0;  // samples that the bodies have been through
  SceneStart start_;
  bool stepping_ = false;
  bool catching_up_ = false;  // since it began from a result
  bool counts_ = false;       // a step has been shown, or has not fitted
  Aim aim_;
  std::uint64_t otherwise_shown_ = std::numeric_limits<std::uint64_t>::max();
  std::int64_t ticks_ = 0, fallback_ticks_ = 0;
};

}  // namespace tactor
