// effect.impact: a short vibration when contact begins, as hard things make it.
#pragma once

#include <array>
#include <vector>

#include "nodes/effect/contact.hpp"
#include "nodes/effect/device_dynamics.hpp"
#include "nodes/effect/stage.hpp"

namespace tactor {

/// When contact begins (touch_of, ContactOnset), and the handle approaches along the surface's force with the speed v
/// (m/s) at the time of the sample that led to the contact, the handle is to move, besides what that force makes of it,
/// with the acceleration v a(t) along it, away from the surface. a(t) is a decaying sinusoid, or a profile that was
/// recorded. The forces for it are computed once, by inversion of the linear device (match_acceleration), scaled by v,
/// and added tick by tick. They fade out behind it. Each transient is made small enough that its peak and the force at
/// its begin stay below `force_max`, and its steps, the last to zero too, below four fifths of what `force_slew` allows
/// a tick; later on the sum is cut at `force_max`. Throws InputError where the profile's times do not rise from 0, or a
/// hand in a grip has no mass.
class Impact final : public Node {
 public:
  struct Params : DeviceDynamics {
    double amplitude = 0;  ///< 1/s
    double frequency = 0;  ///< Hz
    Duration decay;
    Table profile;         ///< t in s, a in 1/s
    double threshold = 0;  ///< N
    Duration quiet;
    double least_speed = 0;  ///< m/s
    double effort = 0;
    double force_max = 0;   ///< N
    double force_slew = 0;  ///< N/s
    double rate = 0;        ///< Hz
  };
  Impact(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  void step(StepContext& context) override;

  Input<ForceSegment> base;
  Input<DeviceState> device;
  Input<PhysicsState> contact;
  Output<ForceSegment> segment;

 private:
  /// A transient that goes on.
  struct Voice {
    Vec3 along_W;  // N a newton of the match: the direction times the speed
    Time begun;
    std::int64_t tick = 0;  // since then
    bool sounds = false;
  };
  void begin(Time now, const Touch& touch, double displayed);
  [[nodiscard]] Vec3 sum(int later) const;

  double threshold_, least_speed_, force_max_, force_slew_;
  Duration tick_;
  EffectStage stage_;
  ContactOnset onset_;
  HandleSpeeds speeds_;
  AccelerationMatch match_;         // for 1 m/s
  double peak_ = 0, steepest_ = 0;  // N, of that: its largest force, and step
  std::array<Voice, 4> voices_;
  double largest_ = 0;  // N
  std::int64_t events_ = 0, limited_events_ = 0, limited_ticks_ = 0;
};

}  // namespace tactor
