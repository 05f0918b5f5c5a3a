// Fitting of auto-regressive models to vector samples: autocovariance, choice of the order, Levinson-Durbin, stability.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>

#include "framework/core/check.hpp"
#include "framework/core/messages.hpp"
#include "nodes/prediction/ar_coefficients.hpp"

namespace tactor {

/// A fitted model x_{t+1} = sum_{i=1..order} phi_i x_{t-i+1}. Order 0: nothing could be fitted.
struct ArFit {
  int order = 0;
  std::array<double, ArCoefficients::max_order> phi{};
  double error_variance = 0;  ///< of the one-step error, summed over the axes, in the squared unit of the samples

  [[nodiscard]] std::span<const double> coefficients() const {
    return std::span(phi).first(static_cast<std::size_t>(order));
  }
};

/// Biased autocovariance of `x` about `mean`, with scalar products over the axes:
/// r[k] = 1/N sum_{t=k}^{N-1} (x_t - mean) . (x_{t-k} - mean), k = 0 .. r.size() - 1, N = x.size().
/// The one divisor for all lags keeps the Toeplitz matrix of r positive semi-definite and the model stable, and the
/// scalar product makes r the same in every rotated frame. Lags from N on are zero.
/// Source: Box, Jenkins, Reinsel, "Time Series Analysis", 4th ed., eq. 2.1.13, over vectors.
void autocovariance(std::span<const Vec3> x, const Vec3& mean, std::span<double> r);

/// True where a model can be fitted to r: r[0] is finite, well above the denormal range, and above `noise`, the
/// rounding that removal of a mean leaves (0 where none was removed).
bool has_energy(double r0, double noise);

/// What is added to the energy of a stream, as a share of it, so that its equations can always be solved. Relative, so
/// that the unit of the samples does not matter.
inline constexpr double energy_ridge = 1e-9;

/// Which order, of those from 1 to the highest, a model gets.
enum class OrderRule {
  highest,
  fpe,  ///< the smallest final prediction error s2 (N + p + 1) / (N - p - 1)
  aic,  ///< the smallest N ln s2 + 2 p
  bic,  ///< the smallest N ln s2 + p ln N
};

struct OrderOptions {
  int max_order = 1;
  OrderRule rule = OrderRule::highest;
  double samples = 0;  ///< N, that the model is fitted to, for the rules that weigh error against order
};

/// Akaike's final prediction error s2 (N + p + 1) / (N - p - 1) of a model of order p with error variance s2.
/// Needs N > p + 1. Source: Akaike, "Fitting autoregressive models for prediction", Ann. Inst. Stat. Math. 21 (1969).
double final_prediction_error(double error_variance, int order, double samples);

/// Compares models of rising order. Sources: Akaike (1969) as above; Akaike, "A new look at the statistical model
/// identification", IEEE Trans. Autom. Control 19 (1974); Schwarz, "Estimating the dimension of a model", Ann. Statist.
/// 6 (1978).
class OrderChoice {
 public:
  explicit OrderChoice(const OrderOptions& options) : options_(options) {}
  /// True where the model of order p with this error variance (> 0) is better than every one before.
  bool better(int p, double error_variance);

 private:
  OrderOptions options_;
  double best_ = std::numeric_limits<double>::infinity();
};

/// Solves the Yule-Walker equations R phi = r for the orders 1 to `max_order` and keeps one of them: Levinson-Durbin on
/// r[0] (1 + energy_ridge), r[1], ... The recursion ends early, at the order reached, where a reflection coefficient
/// leaves (-1, 1) or the error variance is no longer positive; every model returned therefore has its roots inside the
/// unit circle. Needs r.size() > max_order and max_order <= ArCoefficients::max_order. Throws nothing, allocates
/// nothing. Source: Durbin, "The fitting of time-series models", Rev. Inst. Int. Stat. 28 (1960) 233-244.
ArFit fit_yule_walker(std::span<const double> r, const OrderOptions& options);

/// Takes a model of order p - 1 to order p by its reflection coefficient: phi_i -= k phi_{p-i}, phi_p = k.
void step_up(ArFit& model, double reflection);

/// True where every root of z^p - phi_1 z^{p-1} - ... - phi_p is inside the unit circle: the step-down recursion finds
/// every reflection coefficient inside (-1, 1) (the Schur-Cohn test). False for what is not finite. Source: Kay,
/// "Modern Spectral Estimation", 1988, section 6.3.
bool is_stable(std::span<const double> phi);

/// The largest modulus of a root of the model: of z^p - phi_1 z^{p-1} - ... with block = 1, of
/// det(z^p I - Phi_1 z^{p-1} - ...) with block = 3 and `phi` as of ModelStructure::vector. Allocates: for reports
/// alone.
double spectral_radius(std::span<const double> phi, int block);

}  // namespace tactor
