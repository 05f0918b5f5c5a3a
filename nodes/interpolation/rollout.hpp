// interpolation.rollout: goes on with a local model tick by tick.
#pragma once

#include "framework/core/messages.hpp"
#include "framework/node/declare.hpp"
#include "framework/node/new_messages.hpp"
#include "nodes/mechanics/local_rollout.hpp"

namespace tactor {

class Rollout final : public Node {
 public:
  struct Params {
    Duration blend_time;
    std::int32_t iterations = 0;
    double stick_velocity = 0;  // m/s
    double rate = 0;
    bool lead = true;
  };
  Rollout(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  void step(StepContext& context) override;

  Input<LocalModel> model;
  Input<DeviceState> device;
  Output<ForceSegment> segment;

 private:
  [[nodiscard]] Twist acceleration() const;
  Params params_;
  bool torque_;
  LocalRollout rollout_;
  NewMessages<DeviceState> new_states_;
  Stamp used_;
  bool running_ = false;
  Duration tick_;
  Wrench d_, d_rate_;
  Time last_;
  ForceSegment shown_;
  std::array<Stamped<DeviceState>, 64> track_;
  std::size_t count_ = 0;
};

}  // namespace tactor
