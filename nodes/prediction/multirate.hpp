// The predictor that identifies, on line, how the force follows the device's motion.
#pragma once

#include <vector>

#include "nodes/prediction/device_track.hpp"
#include "nodes/prediction/least_squares.hpp"
#include "nodes/prediction/predictor.hpp"

namespace tactor {

/// prediction.multirate: an auto-regressive model with the device's motion as its input and time-varying parameters,
///   y(k) = sum_{i=1..n} a_i y(k - i) + sum_{j=0..m-1} b_j u(k - j),
/// y the change of force from one physics sample to the next and u the device's displacement in the same interval,
/// fitted by recursive least squares with forgetting at the physics' rate. The forecast puts into u(k + 1) what the
/// device has done since the last sample. Torque likewise over rotation vectors.
/// Source: Lee and Lee, "Real-time haptic rendering using multi-rate output-estimation with ARMAX model", ICCAS 2007.
class MultiratePredictor final : public Predictor {
 public:
  static constexpr int max_terms = 8;
  enum class Shared { axes, per_axis };
  struct Params : PredictorParams {
    std::int32_t order = 2;
    std::int32_t input_order = 2;
    double forgetting = 0.98;
    Shared model_structure = Shared::per_axis;
  };
  MultiratePredictor(const Params& params, const NodeContext& context);
  static NodeInfo declare();

  Input<DeviceState> device;

 private:
  using Terms = std::array<Vec3, max_terms + 1>;  // newest first
  // The model of one part of the wrench.
  struct Part {
    std::vector<RecursiveEquations> models;  // one, or one an axis
    Terms changes, ways;
  };
  // The regressors of the change after `changes`, `ways` beginning with its own.
  std::array<Vec3, 2 * max_terms + 1> terms(const Vec3& target, const Vec3* changes, const Vec3* ways) const;
  void learn(Part& part, const Vec3& change, const Vec3& way);
  // Adds to each step what its model expects of one part of the wrench, given the device's ways from step to step.
  Outcome foresee(const Part& part, std::span<const Wrench> ways, Vec3 Wrench::*member,
                  std::span<Wrench> predicted) const;

  void read_inputs() override { track_.read(device); }
  void take(const Stamped<Wrench>& sample) override;
  Outcome predict(Duration horizon, std::span<Wrench> predicted) override;
  [[nodiscard]] bool is_warm() const override;

  Params params_;
  DeviceTrack track_;
  Part force_part_;
  Part torque_part_;
  Stamped<Wrench> newest_;
  Pose X_WD_;  // at the newest sample
  int seen_ = 0;
  std::int64_t learnt_ = 0;  // samples that the models have seen
};

}  // namespace tactor
