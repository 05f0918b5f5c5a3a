// Vector auto-regressive models: a 3x3 matrix a lag, by the recursion of Whittle.
#pragma once

#include <array>
#include <span>

#include "nodes/prediction/ar_coefficients.hpp"
#include "nodes/prediction/autoregression.hpp"

namespace tactor {

/// A fitted model x_{t+1} = sum_{i=1..order} Phi_i x_{t-i+1}, Phi_i as of ModelStructure::vector. Order 0: nothing was
/// fitted.
struct VectorArFit {
  int order = 0;
  std::array<double, 9 * ArCoefficients::max_vector_order> phi{};
  double error_variance = 0;  ///< trace of the one-step error's covariance
};

/// Solves the multichannel Yule-Walker equations of the samples about `mean` for the orders 1 to `max_order` and keeps
/// one of them. The biased matrix autocovariances Gamma_k = 1/N sum_t x_t x_{t-k}^T keep every model stable; the ridge
/// on Gamma_0 is energy_ridge of its trace, so that forces in a plane or along a line can be fitted. A rotation of the
/// world rotates the model with it. The rules compare by the determinant of the error's covariance with 9 p parameters:
/// FPE = |S| ((N + 3 p + 1) / (N - 3 p - 1))^3. Source: Whittle, "On the fitting of multivariate autoregressions",
/// Biometrika 50 (1963) 129-134; Brockwell and Davis, "Time Series: Theory and Methods", 2nd ed., section 11.4.
VectorArFit fit_whittle(std::span<const Vec3> x, const Vec3& mean, const OrderOptions& options);

}  // namespace tactor
