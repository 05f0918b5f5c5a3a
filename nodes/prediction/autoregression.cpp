#include "nodes/prediction/autoregression.hpp"

#include <cmath>
#include <limits>

namespace tactor {

void autocovariance(std::span<const Vec3> x, const Vec3& mean, std::span<double> r) {
  const double divisor = x.empty() ? 1.0 : static_cast<double>(x.size());
  for (std::size_t k = 0; k < r.size(); ++k) {
    double sum = 0;
    for (std::size_t t = k; t < x.size(); ++t) sum += dot(x[t] - mean, x[t - k] - mean);
    r[k] = sum / divisor;
  }
}

bool has_energy(double r0, double noise) {
  // Below this, quotients of the lags no longer have all their digits.
  constexpr double smallest = std::numeric_limits<double>::min() / std::numeric_limits<double>::epsilon();
  return std::isfinite(r0) && r0 > smallest && r0 > noise;
}

double final_prediction_error(double error_variance, int order, std::int64_t samples) {
  TACTOR_ASSERT(samples > order + 1);
  return error_variance * static_cast<double>(samples + order + 1) / static_cast<double>(samples - order - 1);
}

ArFit fit_yule_walker(std::span<const double> r, const YuleWalkerOptions& options) {
  TACTOR_DEMAND(options.max_order >= 1 && options.max_order <= ArCoefficients::max_order);
  TACTOR_DEMAND(r.size() > static_cast<std::size_t>(options.max_order));
  constexpr double ridge = 1e-9;
  std::array<double, ArCoefficients::max_order> phi{};
  std::array<double, ArCoefficients::max_order> previous{};
  double variance = r[0] * (1.0 + ridge);
  double best = std::numeric_limits<double>::infinity();
  ArFit fit;
  for (int p = 1; p <= options.max_order; ++p) {
    const auto n = static_cast<std::size_t>(p);
    double numerator = r[n];
    for (std::size_t i = 1; i < n; ++i) numerator -= phi[i - 1] * r[n - i];
    const double reflection = numerator / variance;
    // Written so that NaN ends the recursion as well.
    if (!(std::abs(reflection) < 1.0)) break;
    previous = phi;
    for (std::size_t i = 1; i < n; ++i) phi[i - 1] = previous[i - 1] - reflection * previous[n - i - 1];
    phi[n - 1] = reflection;
    variance *= (1.0 - reflection) * (1.0 + reflection);
    if (!(variance > 0.0)) break;
    if (options.by_fpe) {
      if (options.samples <= p + 1) break;
      const double error = final_prediction_error(variance, p, options.samples);
      if (!(error < best)) continue;
      best = error;
    }
    fit.order = p;
    fit.phi = phi;
    fit.error_variance = variance;
  }
  return fit;
}

}  // namespace tactor
