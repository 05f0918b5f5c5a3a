// prediction.local: goes back to the stamp of each physics result and simulates from there to now.
#pragma once

#include "framework/core/messages.hpp"
#include "framework/node/declare.hpp"
#include "framework/node/new_messages.hpp"
#include "nodes/mechanics/local_rollout.hpp"
#include "nodes/prediction/sample_window.hpp"

namespace tactor {

/// For each physics result: puts the bodies where it has them, moves them through the device samples since its stamp
/// against the contacts around them (LocalRollout), and sends what to go on from.
class LocalPredictor final : public Node {
 public:
  struct Params {
    std::int32_t iterations = 0;
    double stick_velocity = 0;  // m/s
    bool resimulate = true;
    bool curvature = true;
    double stiffness_scale = 0;
    double friction_scale = 0;
  };
  LocalPredictor(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  void step(StepContext& context) override;
  /// `prediction.resimulated_samples` (mean of a result), `prediction.rejected_results`, `prediction.rejected_samples`
  /// and `prediction.failed_steps` (results not sent, because a step did not converge).
  void report(Report& report) const override;

  Input<BodyStates> bodies;
  Input<LocalContacts> contacts;
  Input<CouplingLaw> law;
  Input<DeviceState> device;
  Output<LocalModel> model;

 private:
  void take_samples();
  void take_contacts();

  Params params_;
  LocalRollout rollout_;
  LocalModel start_;
  NewMessages<DeviceState> new_states_;
  SampleWindow<Stamped<DeviceState>> track_{512};
  std::int64_t results_ = 0, resimulated_ = 0, rejected_results_ = 0, rejected_samples_ = 0, failed_ = 0;
};

}  // namespace tactor
