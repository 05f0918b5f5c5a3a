// prediction.local: goes back to the stamp of each physics result and simulates from there to now.
#pragma once

#include "framework/core/messages.hpp"
#include "framework/node/declare.hpp"
#include "framework/node/new_messages.hpp"
#include "nodes/mechanics/local_rollout.hpp"
#include "nodes/prediction/sample_window.hpp"

namespace tactor {

class LocalPredictor final : public Node {
 public:
  struct Params {
    std::int32_t max_contacts = 0;
    std::int32_t iterations = 0;
    double stick_velocity = 0;  // m/s
    bool resimulate = true;
  };
  LocalPredictor(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  void step(StepContext& context) override;

  Input<BodyStates> bodies;
  Input<LocalContacts> contacts;
  Input<CouplingLaw> law;
  Input<DeviceState> device;
  Output<LocalModel> model;
  Output<BodyStates> expected;

 private:
  Params params_;
  LocalRollout rollout_;
  LocalModel start_;
  NewMessages<DeviceState> new_states_;
  SampleWindow<Stamped<DeviceState>> track_{512};
};

}  // namespace tactor
