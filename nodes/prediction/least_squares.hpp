// Linear regression on normal equations, of every order at once, and the two ways here to come by them.
#pragma once

#include "nodes/prediction/ar_coefficients.hpp"
#include "nodes/prediction/autoregression.hpp"

namespace tactor {

/// The sums of products of a target z_0 and its regressors z_1 .. z_n, n <= max_regressors: sum z_i z_j, symmetric.
/// Storage is inside, nothing allocates.
class NormalEquations {
 public:
  static constexpr int max_regressors = ArCoefficients::max_order;

  explicit NormalEquations(int regressors) : size_(static_cast<std::size_t>(regressors) + 1) {
    TACTOR_DEMAND(regressors >= 1 && regressors <= max_regressors);
  }
  [[nodiscard]] int regressors() const { return static_cast<int>(size_) - 1; }
  /// Entry (i, j), for j <= i; the other half is not stored.
  double& at(std::size_t i, std::size_t j) { return sums_[i * stride + j]; }
  [[nodiscard]] double at(std::size_t i, std::size_t j) const { return sums_[i * stride + j]; }
  void clear() { sums_.fill(0); }

  /// Weighs all former products by `forgetting` and adds those of z_i . z_j, i, j = 0 .. regressors().
  void add(std::span<const Vec3> z, double forgetting);

  /// The coefficients c of z_0 = sum_{i=1..p} c_i z_i that minimise the summed square error plus the ridge
  /// sum_i `ridge` S_ii c_i^2, S the sums: relative to each regressor, so no unit matters. A regressor without energy
  /// gets the coefficient 0. One Cholesky factorisation gives the error of every p; `options` chooses, samples being
  /// those that the sums hold. `error_variance` is the mean square error. Order 0 where nothing can be solved.
  [[nodiscard]] ArFit solve(double ridge, const OrderOptions& options) const;

 private:
  static constexpr std::size_t stride = max_regressors + 1;
  std::size_t size_;
  std::array<double, stride * stride> sums_{};
};

/// The normal equations of the covariance method, sums over t = p .. N - 1 of x_{t-i} . x_{t-j} with p the regressors
/// of `equations`, out of autocovariance sums and the samples at the edges (as of fit_burg()): O(p^2), whatever N is.
/// `ridge` N r[0], an energy that the sums surely know, is added to the diagonal. Source: Kay, "Modern Spectral
/// Estimation", 1988, section 7.3.
void covariance_equations(std::span<const double> r, std::int64_t samples, std::span<const Vec3> first,
                          std::span<const Vec3> last, double ridge, NormalEquations& equations);

/// Recursive least squares in information form: with each sample the normal equations are weighed by the forgetting
/// factor and the newest products are added; solve() inverts them where a model is wanted. The matrix kept is the
/// inverse of the P of the usual recursion; it stays symmetric, bounded by energy / (1 - forgetting), and does not wind
/// up while nothing excites it: samples of zero count as samples, and leave the coefficients as they are. Where a
/// sample is not zero, and the target and every regressor hold less than 1e-12 of the energy remembered of them, it
/// starts anew: what is left of the past would outweigh them for long. Source: Ljung, "System Identification", 2nd ed.,
/// section 11.2; Haykin, "Adaptive Filter Theory", 4th ed., chapter 9.
class RecursiveEquations {
 public:
  RecursiveEquations(int regressors, double forgetting) : equations_(regressors), forgetting_(forgetting) {}
  /// Takes in a target z_0 and its regressors, whose squares are finite.
  void add(std::span<const Vec3> z);
  [[nodiscard]] const NormalEquations& equations() const { return equations_; }
  /// The samples that the sums stand for: the sum of their weights.
  [[nodiscard]] double samples() const { return weight_; }
  /// The mean energy of a target, by the weights.
  [[nodiscard]] double energy() const { return weight_ > 0 ? equations_.at(0, 0) / weight_ : 0.0; }

 private:
  NormalEquations equations_;
  double forgetting_;
  double weight_ = 0;
};

}  // namespace tactor
