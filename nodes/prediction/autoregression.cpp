#include "nodes/prediction/autoregression.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

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

double final_prediction_error(double error_variance, int order, double samples) {
  TACTOR_ASSERT(samples > order + 1);
  return error_variance * (samples + order + 1) / (samples - order - 1);
}

bool OrderChoice::better(int p, double error_variance) {
  if (options_.rule == OrderRule::highest) return true;
  const double n = options_.samples;
  if (n <= p + 1) return false;
  double value = 0;
  switch (options_.rule) {
    case OrderRule::aic:
      value = n * std::log(error_variance) + 2.0 * p;
      break;
    case OrderRule::bic:
      value = n * std::log(error_variance) + p * std::log(n);
      break;
    default:
      value = final_prediction_error(error_variance, p, n);
      break;
  }
  if (!(value < best_)) return false;
  best_ = value;
  return true;
}

void step_up(ArFit& model, double reflection) {
  const std::array<double, ArCoefficients::max_order> previous = model.phi;
  const auto n = static_cast<std::size_t>(++model.order);
  for (std::size_t i = 1; i < n; ++i) model.phi[i - 1] = previous[i - 1] - reflection * previous[n - i - 1];
  model.phi[n - 1] = reflection;
}

ArFit fit_yule_walker(std::span<const double> r, const OrderOptions& options) {
  TACTOR_DEMAND(options.max_order >= 1 && options.max_order <= ArCoefficients::max_order);
  TACTOR_DEMAND(r.size() > static_cast<std::size_t>(options.max_order));
  OrderChoice choice(options);
  ArFit model;
  model.error_variance = r[0] * (1.0 + energy_ridge);
  ArFit best;
  while (model.order < options.max_order) {
    const auto n = static_cast<std::size_t>(model.order) + 1;
    double numerator = r[n];
    for (std::size_t i = 1; i < n; ++i) numerator -= model.phi[i - 1] * r[n - i];
    const double reflection = numerator / model.error_variance;
    // Written so that NaN ends the recursion as well.
    if (!(std::abs(reflection) < 1.0)) break;
    step_up(model, reflection);
    model.error_variance *= (1.0 - reflection) * (1.0 + reflection);
    if (!(model.error_variance > 0.0)) break;
    if (choice.better(model.order, model.error_variance)) best = model;
  }
  return best;
}

bool is_stable(std::span<const double> phi) {
  TACTOR_DEMAND(phi.size() <= ArCoefficients::max_order);
  std::array<double, ArCoefficients::max_order> model{};
  std::copy(phi.begin(), phi.end(), model.begin());
  for (std::size_t n = phi.size(); n > 0; --n) {
    const double reflection = model[n - 1];
    if (!(std::abs(reflection) < 1.0)) return false;
    const double share = 1.0 / ((1.0 - reflection) * (1.0 + reflection));
    const std::array<double, ArCoefficients::max_order> longer = model;
    for (std::size_t i = 1; i < n; ++i) model[i - 1] = share * (longer[i - 1] + reflection * longer[n - i - 1]);
  }
  return true;
}

double spectral_radius(std::span<const double> phi, int block) {
  const Eigen::Index m = block;
  const auto order = static_cast<Eigen::Index>(phi.size()) / (m * m);
  if (order == 0) return 0;
  Eigen::MatrixXd companion = Eigen::MatrixXd::Zero(m * order, m * order);
  for (Eigen::Index i = 0; i < order; ++i) {
    for (Eigen::Index r = 0; r < m; ++r) {
      for (Eigen::Index c = 0; c < m; ++c) {
        companion(r, m * i + c) = phi[static_cast<std::size_t>(m * m * i + m * r + c)];
      }
    }
  }
  companion.bottomLeftCorner(m * (order - 1), m * (order - 1)).setIdentity();
  return companion.eigenvalues().cwiseAbs().maxCoeff();
}

}  // namespace tactor
