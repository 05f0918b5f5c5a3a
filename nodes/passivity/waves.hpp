// passivity.waves: a line of wave variables in place of the coupling, passive whatever the delay to physics and back.
#pragma once

#include <cstdint>

#include "framework/core/messages.hpp"
#include "framework/node/declare.hpp"
#include "framework/node/new_messages.hpp"
#include "nodes/passivity/on_its_way.hpp"
#include "nodes/passivity/port_samples.hpp"
#include "nodes/passivity/wave_end.hpp"

namespace tactor {

/// Stands where the coupling stands, on the device's side of the delays (see WaveEnd for the equations). `wave` tells
/// physics where the handle's end of the tool's damper is, `parameters` the damper, and `state` brings back where both
/// are: the returning wave of a result at its time is 2 p_WT - p_WD. Both ways may delay as they like, evenly or not.
///
/// The tool's weight w does not go through the line: the line carries F - w, and w is added at the handle. What the
/// line makes of F - w leaves with the velocity -w / b on top, by which the damper holds the tool against its weight.
/// So the wave that physics gets is still that of v - F / b, the line needs no energy of the weight, and what it keeps
/// passive is the port without the weight on the way of the handle. No force commanded is no weight displayed: zero
/// goes into the line as zero.
///
/// The device commands what is sent now at the first tick after now. In a real-time lane of a live run the newest
/// sample is a tick old by then, or more. The forces that were sent for the ticks between, and are not shown yet, are
/// reckoned with as if the device commanded them. After `most_ahead` ticks without a sample nothing is known of the
/// handle, and zero is sent.
///
/// A step allocates, locks and waits for nothing.
class Waves final : public Node {
 public:
  struct Params {
    double impedance = 0;   ///< N s/m
    double mass = 0;        ///< kg, of the handle
    double catch_up = 0;    ///< s
    double period_min = 0;  ///< s
    double rate = 0;        ///< Hz
  };
  /// Throws InputError where the scene has torques, and where the handle is too light for the impedance.
  Waves(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  void start(StepContext& context) override;
  void step(StepContext& context) override;

  Input<DeviceState> device;
  Input<Wrench> commanded;
  Input<PhysicsState> state;
  Output<DeviceState> wave;
  Output<CouplingParameters> parameters;
  Output<Wrench> force;
  Output<ForceSegment> segment;

 private:
  void take_sample(const Stamped<DeviceState>& sample);
  void send_wave();
  [[nodiscard]] Vec3 without_weight(const Vec3& f) const;
  [[nodiscard]] Vec3 hoist(Time at) const;
  void take_result(Time now);
  void send_force(Time now);

  Params params_;
  Duration tick_, period_min_;
  Vec3 weight_W_;  // N, of the tool
  WaveEnd end_;
  PortSamples samples_;
  NewMessages<PhysicsState> new_results_;
  Vec3 held_;   // N, commanded now, without the weight
  Time begin_;  // of the line
  bool has_sent_ = false;
  Vec3 sent_;     // m, the outgoing wave that was sent last
  Time sent_at_;  // its time
  bool has_result_ = false;
  OnItsWay<Vec3> forces_;  // N, without the weight
  std::uint64_t ticks_ = 0, cut_ = 0;
  double lag_sum_ = 0;  // m^2
};

}  // namespace tactor
