// The refitter: auto-regressive coefficients from the last N physics samples, anew as samples come.
#pragma once

#include <cstdint>
#include <optional>

#include "framework/core/messages.hpp"
#include "framework/node/declare.hpp"
#include "framework/node/new_messages.hpp"
#include "nodes/prediction/ar_coefficients.hpp"
#include "nodes/prediction/part_estimator.hpp"
#include "nodes/prediction/uniform_grid.hpp"

namespace tactor {

/// prediction.refit: fits auto-regressive models to the force and to the torque of the last N samples.
/// Source: Hou and Sourina, "Real-time Adaptive Prediction Method for Smooth Haptic Rendering", eq. 5 to 11, with one
/// common divisor for all lags where eq. 5 prints N - 1, and scalar products over the axes. The other methods and
/// products are named where they are computed.
class Refitter final : public Node {
 public:
  struct Params {
    std::int32_t window = 300;
    double window_time = 0;
    std::int32_t order = 0;
    std::int32_t max_order = 20;
    OrderRule order_by = OrderRule::fpe;
    ArMethod method = ArMethod::yule_walker;
    ModelStructure model_structure = ModelStructure::axes;
    double forgetting = 0.99;
    Detrend detrend = Detrend::difference;
    bool resample = false;
    std::int32_t period = 1;
  };
  /// Throws InputError where `order` is more than the samples allow, and where options exclude each other.
  Refitter(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  void step(StepContext& context) override;
  [[nodiscard]] std::optional<Time> warm_since() const override { return warm_since_; }

  Input<Wrench> force;
  Output<ArCoefficients> coefficients;

 private:
  static void declare_metrics(Declare<Refitter>& node);
  /// The quantile `share` of the spectral radii of the models of force; empty if there is none.
  [[nodiscard]] std::optional<double> radius(double share) const;
  void take(const Stamped<Wrench>& sample);
  [[nodiscard]] bool ready() const;
  [[nodiscard]] bool window_is_full() const;

  Params params_;
  bool torque_;
  int top_order_;
  PartEstimator force_part_;
  PartEstimator torque_part_;
  SampleWindow<Time> times_;
  UniformGrid grid_;
  NewMessages<Wrench> samples_;
  Wrench last_;
  bool any_ = false, started_ = false;
  std::optional<Time> warm_since_;
  std::int64_t since_refit_ = 0;
  std::int64_t taken_ = 0;  // samples, or differences, that the model has seen
  std::int64_t refits_ = 0, rejected_ = 0, rejected_samples_ = 0, order_sum_ = 0;
};

}  // namespace tactor
