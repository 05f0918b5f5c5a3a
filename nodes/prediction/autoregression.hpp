// Fitting of auto-regressive models to vector samples: autocovariance, Levinson-Durbin, order by final prediction
// error.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "framework/core/check.hpp"
#include "framework/core/messages.hpp"

namespace tactor {

/// A fitted model x_{t+1} = sum_{i=1..order} phi_i x_{t-i+1}. Order 0: nothing could be fitted.
struct ArFit {
  int order = 0;
  std::array<double, ArCoefficients::max_order> phi{};
  double error_variance = 0;  ///< of the one-step error, summed over the axes, in the squared unit of the samples
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

/// Solves the Yule-Walker equations R phi = r for the orders 1 to `max_order` and keeps one of them.
struct YuleWalkerOptions {
  int max_order = 1;
  bool by_fpe = false;       ///< false: the order is max_order; true: the one of the smallest final prediction error
  std::int64_t samples = 0;  ///< N, that r was made of; for the final prediction error
};

/// Levinson-Durbin on r[0] (1 + 1e-9), r[1], ... The ridge is relative, so the unit of the samples does not matter. The
/// recursion ends early, at the order reached, where a reflection coefficient leaves (-1, 1) or the error variance is
/// no longer positive; every model returned therefore has its roots inside the unit circle. Needs r.size() > max_order
/// and max_order <= ArCoefficients::max_order. Throws nothing, allocates nothing. Source: Durbin, "The fitting of
/// time-series models", Rev. Inst. Int. Stat. 28 (1960) 233-244.
ArFit fit_yule_walker(std::span<const double> r, const YuleWalkerOptions& options);

/// Akaike's final prediction error s2 (N + p + 1) / (N - p - 1) of a model of order p with error variance s2.
/// Needs N > p + 1. Source: Akaike, "Fitting autoregressive models for prediction", Ann. Inst. Stat. Math. 21 (1969).
double final_prediction_error(double error_variance, int order, std::int64_t samples);

}  // namespace tactor
