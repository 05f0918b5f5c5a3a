// The refitter: auto-regressive coefficients from the last N physics samples, anew as samples come.
#pragma once

#include <array>

#include "framework/core/messages.hpp"
#include "framework/node/declare.hpp"
#include "framework/node/new_messages.hpp"
#include "nodes/prediction/autoregression.hpp"
#include "nodes/prediction/sample_window.hpp"

namespace tactor {

/// prediction.refit: solves the Yule-Walker equations for the force and for the torque of the last N samples.
/// Source: Hou and Sourina, "Real-time Adaptive Prediction Method for Smooth Haptic Rendering", eq. 5 to 11, with one
/// common divisor for all lags where eq. 5 prints N - 1, and scalar products over the axes.
class Refitter final : public Node {
 public:
  enum class Method { yule_walker };
  struct Params {
    std::int32_t window = 300;
    std::int32_t order = 0;
    std::int32_t max_order = 20;
    Method method = Method::yule_walker;
    Removal remove = Removal::difference;
    std::int32_t period = 1;
  };
  /// Throws InputError where `order` is more than a third of `window`.
  Refitter(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  void step(StepContext& context) override;
  void report(Report& report) const override;

  Input<Wrench> force;
  Output<ArCoefficients> coefficients;

 private:
  ArFit fit(AutocovarianceWindow& window);

  Params params_;
  bool torque_;
  int top_order_;
  AutocovarianceWindow force_window_;
  AutocovarianceWindow torque_window_;
  NewMessages<Wrench> samples_;
  Wrench last_;
  bool any_ = false;
  std::int64_t since_refit_ = 0;
  std::int64_t refits_ = 0, rejected_ = 0, rejected_samples_ = 0, order_sum_ = 0;
};

}  // namespace tactor
