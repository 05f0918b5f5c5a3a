// The auto-regressive predictor, with fixed coefficients or with those a refitter sends.
#pragma once

#include <array>
#include <vector>

#include "framework/node/new_messages.hpp"
#include "nodes/prediction/parameters.hpp"
#include "nodes/prediction/sample_window.hpp"

namespace tactor {

/// prediction.ar: F_{t+1|t} = sum_i phi_i F_{t-i+1}, about the mean or over differences where the coefficients were
/// fitted so (see Removal). One set of coefficients serves the three axes of force, another those of torque.
/// Source: Hou and Sourina, "Real-time Adaptive Prediction Method for Smooth Haptic Rendering", eq. 4, with F_{t-i+1}
/// where the equation repeats F_{t+1|t}.
class ArPredictor final : public Node {
 public:
  enum class Source { fixed, refit };
  struct Params : PredictorParams {
    Source coefficients = Source::refit;
    std::vector<double> force_coefficients;
    std::vector<double> torque_coefficients;
    Removal remove = Removal::difference;
    std::int32_t mean_window = 300;
  };
  /// Throws InputError where more coefficients are given than ArCoefficients can hold.
  ArPredictor(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  void step(StepContext& context) override;
  void report(Report& report) const override { guard_.report(report); }

  Input<Wrench> force;
  Input<ArCoefficients> coefficients;
  Output<Forecast> forecast;

 private:
  enum class Outcome { predicted, warm_up, nothing_fitted };
  Outcome predict(const SampleWindow& history, std::span<const double> phi, Vec3& predicted) const;

  Params params_;
  ForecastGuard guard_;
  PeriodEstimate period_;
  NewMessages<Wrench> samples_;
  ArCoefficients model_;
  SampleWindow force_history_;
  SampleWindow torque_history_;
};

}  // namespace tactor
