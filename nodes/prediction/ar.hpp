// The auto-regressive predictor, with fixed coefficients or with those a refitter sends.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "nodes/prediction/ar_coefficients.hpp"
#include "nodes/prediction/predictor.hpp"
#include "nodes/prediction/sample_window.hpp"

namespace tactor {

/// prediction.ar: F_{t+1|t} = sum_i phi_i F_{t-i+1}, about the mean or over differences where the coefficients were
/// fitted so (see Detrend), phi_i a number, a number an axis or a matrix (see ModelStructure). On a grid of even times
/// the history is interpolated linearly and the model iterated to the horizon. Source: Hou and Sourina, "Real-time
/// Adaptive Prediction Method for Smooth Haptic Rendering", eq. 4, with F_{t-i+1} where the equation repeats F_{t+1|t}.
class ArPredictor final : public Predictor {
 public:
  enum class Source { fixed, refit };
  struct Params : PredictorParams {
    Source coefficients = Source::refit;
    std::vector<double> force_coefficients;
    std::vector<double> torque_coefficients;
    Detrend detrend = Detrend::difference;
    std::int32_t mean_window = 300;
  };
  /// Throws InputError where more coefficients are given than ArCoefficients::max_order.
  ArPredictor(const Params& params, const NodeContext& context);
  static NodeInfo declare();

  Input<ArCoefficients> coefficients;

 private:
  void read_inputs() override;
  void take(const Stamped<Wrench>& sample) override { history_.push(sample); }
  Outcome predict(Duration horizon, std::span<Wrench> predicted) override;
  [[nodiscard]] bool is_warm() const override;
  // Writes up to `count` past forces, newest first, as they came or on the model's grid; returns how many there are.
  std::size_t gather(std::size_t count, std::span<Wrench> past) const;
  [[nodiscard]] Wrench mean() const;

  Params params_;
  ArCoefficients model_;
  SampleWindow<Stamped<Wrench>> history_;
};

}  // namespace tactor
