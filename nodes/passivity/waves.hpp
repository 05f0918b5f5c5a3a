// passivity.waves: a line of wave variables in place of the coupling, passive whatever the delay to physics and back.
#pragma once

#include "framework/core/messages.hpp"
#include "framework/node/declare.hpp"
#include "framework/node/new_messages.hpp"
#include "nodes/passivity/port_samples.hpp"
#include "nodes/passivity/wave_end.hpp"

namespace tactor {

/// Stands where the coupling stands, on the device's side of the delays (see WaveEnd for the equations). `wave` tells
/// physics where the handle's end of the tool's damper is, `parameters` the damper, and `state` brings back where both
/// are: the returning wave of a result at its time is 2 p_WT - p_WD. Both ways may delay as they like, evenly or not.
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
  /// waves.cut_share, waves.lag_rms_m, waves.energy_out_J, waves.energy_played_J.
  void report(Report& report) const override;

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
  void take_result(Time now);

  Params params_;
  Duration tick_, period_min_;
  Vec3 weight_W_;  // N, of the tool
  WaveEnd end_;
  PortSamples samples_;
  NewMessages<PhysicsState> new_results_;
  Vec3 held_;  // N, commanded now
  bool has_sent_ = false;
  Vec3 sent_;     // m, the outgoing wave that was sent last
  Time sent_at_;  // its time
  bool has_result_ = false;
  Vec3 begin_;  // m, where the line began
  std::uint64_t ticks_ = 0, cut_ = 0;
  double lag_sum_ = 0;  // m^2
};

}  // namespace tactor
