// Fits the model of one part of a wrench, its force or its torque, in any of the kinds of products.
#pragma once

#include <optional>
#include <vector>

#include "nodes/prediction/ar_coefficients.hpp"
#include "nodes/prediction/ar_estimator.hpp"

namespace tactor {

/// One part of a wrench: one estimator for scalar products, three where each axis has a model of its own, or the
/// samples themselves for a vector model.
class PartEstimator {
 public:
  /// ModelStructure::vector knows ArMethod::yule_walker alone.
  PartEstimator(const ArEstimatorOptions& options, ModelStructure model_structure);

  void push(const Vec3& x);
  void drop_oldest();
  [[nodiscard]] double samples() const;
  /// Fits as ArEstimator::fit(), writes the coefficients in the layout of ModelStructure and their error variance, and
  /// returns the order, 0 where nothing could be fitted. Per axis it is the highest of the three; an axis without a
  /// model beside others that have one is held (`hold` is its first coefficient).
  int fit(int order, OrderRule rule, double hold, std::array<double, ArCoefficients::capacity>& phi, double& variance);
  /// Models that least squares had made unstable.
  [[nodiscard]] std::int64_t unstable() const { return unstable_; }
  /// The spectral radii of a sparse choice of the models so far, at most `kept`, evenly over time. Allocates.
  [[nodiscard]] std::vector<double> spectral_radii() const;

 private:
  struct Kept {
    int order = 0;
    std::array<double, ArCoefficients::capacity> phi;
  };
  static constexpr std::size_t kept = 128;
  int fit_axes(int order, OrderRule rule, double hold, std::array<double, ArCoefficients::capacity>& phi,
               double& variance);
  int fit_vector(int order, OrderRule rule, std::array<double, ArCoefficients::capacity>& phi, double& variance);
  void keep(int order, const std::array<double, ArCoefficients::capacity>& phi);

  ArEstimatorOptions options_;
  ModelStructure model_structure_;
  std::vector<ArEstimator> estimators_;
  std::optional<SampleWindow<Vec3>> samples_;
  std::vector<Vec3> ordered_;
  std::int64_t unstable_ = 0;
  std::vector<Kept> models_;
  std::int64_t fits_ = 0, stride_ = 1;
};

}  // namespace tactor
