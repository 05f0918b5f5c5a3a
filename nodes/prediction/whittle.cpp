#include "nodes/prediction/whittle.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/LU>
#include <cmath>

namespace tactor {

namespace {

using Eigen::Matrix3d;
constexpr int top = ArCoefficients::max_vector_order;

Eigen::Vector3d column(const Vec3& v) {
  return {v.x, v.y, v.z};
}

// Lower is better, as OrderChoice does for a single variance.
double criterion(OrderRule rule, double log_determinant, int p, double n) {
  switch (rule) {
    case OrderRule::aic:
      return n * log_determinant + 2.0 * 9 * p;
    case OrderRule::bic:
      return n * log_determinant + 9.0 * p * std::log(n);
    default:
      return log_determinant + 3 * std::log((n + 3 * p + 1) / (n - 3 * p - 1));
  }
}

}  // namespace

VectorArFit fit_whittle(std::span<const Vec3> x, const Vec3& mean, const OrderOptions& options) {
  TACTOR_DEMAND(options.max_order >= 1 && options.max_order <= top);
  std::array<Matrix3d, top + 1> gamma;
  for (std::size_t k = 0; k <= static_cast<std::size_t>(options.max_order); ++k) {
    gamma[k].setZero();
    for (std::size_t t = k; t < x.size(); ++t) gamma[k] += column(x[t] - mean) * column(x[t - k] - mean).transpose();
    gamma[k] /= static_cast<double>(x.size());
  }
  gamma[0].diagonal().array() += energy_ridge * gamma[0].trace();

  // A predicts forwards, B backwards; their error covariances.
  std::array<Matrix3d, top> A;
  std::array<Matrix3d, top> B;
  Matrix3d forward = gamma[0];
  Matrix3d backward = gamma[0];
  VectorArFit fit;
  double best = std::numeric_limits<double>::infinity();
  for (int p = 1; p <= options.max_order; ++p) {
    const auto n = static_cast<std::size_t>(p);
    Matrix3d delta = gamma[n];
    for (std::size_t i = 1; i < n; ++i) delta -= A[i - 1] * gamma[n - i];
    const Eigen::LLT<Matrix3d> forward_factor(forward);
    const Eigen::LLT<Matrix3d> backward_factor(backward);
    if (forward_factor.info() != Eigen::Success || backward_factor.info() != Eigen::Success) break;
    const Matrix3d a = backward_factor.solve(delta.transpose()).transpose();  // delta backward^-1
    const Matrix3d b = forward_factor.solve(delta).transpose();               // delta^T forward^-1
    const std::array<Matrix3d, top> A_old = A;
    const std::array<Matrix3d, top> B_old = B;
    for (std::size_t i = 1; i < n; ++i) {
      A[i - 1] = A_old[i - 1] - a * B_old[n - i - 1];
      B[i - 1] = B_old[i - 1] - b * A_old[n - i - 1];
    }
    A[n - 1] = a;
    B[n - 1] = b;
    forward -= a * delta.transpose();
    backward -= b * delta;
    forward = 0.5 * (forward + forward.transpose()).eval();
    backward = 0.5 * (backward + backward.transpose()).eval();
    const Eigen::LLT<Matrix3d> error(forward);
    if (error.info() != Eigen::Success) break;
    const double log_determinant = 2 * error.matrixLLT().diagonal().array().log().sum();
    if (!std::isfinite(log_determinant)) break;
    if (options.rule != OrderRule::highest) {
      if (options.samples <= 3 * p + 1) break;
      const double value = criterion(options.rule, log_determinant, p, options.samples);
      if (!(value < best)) continue;
      best = value;
    }
    fit.order = p;
    fit.error_variance = forward.trace();
    for (std::size_t i = 0; i < n; ++i) {
      Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(fit.phi.data() + 9 * i) = A[i];
    }
  }
  return fit;
}

}  // namespace tactor
