#include "nodes/prediction/least_squares.hpp"

#include <algorithm>
#include <cmath>

namespace tactor {

void NormalEquations::add(std::span<const Vec3> z, double forgetting) {
  TACTOR_ASSERT(z.size() == size_);
  for (std::size_t i = 0; i < size_; ++i) {
    for (std::size_t j = 0; j <= i; ++j) at(i, j) = forgetting * at(i, j) + dot(z[i], z[j]);
  }
}

ArFit NormalEquations::solve(double ridge, const OrderOptions& options) const {
  TACTOR_DEMAND(options.max_order >= 1 && options.max_order <= regressors() && options.samples > 0);
  const auto n = static_cast<std::size_t>(options.max_order);
  // L of the factorisation and y = L^-1 (sums of regressor and target), row by row; the error of order p is what the
  // first p entries of y leave of the target's energy.
  std::array<double, stride * stride> L;
  std::array<double, stride> y;
  OrderChoice choice(options);
  ArFit fit;
  double error = at(0, 0);
  const double energy = error;
  for (std::size_t i = 0; i < n; ++i) {
    const double own = at(i + 1, i + 1);
    for (std::size_t j = 0; j < i; ++j) {
      double sum = at(i + 1, j + 1);
      for (std::size_t k = 0; k < j; ++k) sum -= L[i * stride + k] * L[j * stride + k];
      L[i * stride + j] = sum / L[j * stride + j];
    }
    double pivot = own * (1.0 + ridge);
    double right = at(i + 1, 0);
    for (std::size_t k = 0; k < i; ++k) {
      pivot -= L[i * stride + k] * L[i * stride + k];
      right -= L[i * stride + k] * y[k];
    }
    // A pivot that the ridge does not carry is rounding: the regressor says nothing new.
    if (!(pivot > 0.25 * ridge * own) || !(own > 0.0)) {
      if (!std::isfinite(own)) break;
      // An infinite pivot leaves it out: everything is divided by it.
      for (std::size_t k = 0; k < i; ++k) L[i * stride + k] = 0;
      pivot = std::numeric_limits<double>::infinity();
    }
    L[i * stride + i] = std::sqrt(pivot);
    y[i] = right / L[i * stride + i];
    error -= y[i] * y[i];
    if (!std::isfinite(error)) break;
    const double floor = std::numeric_limits<double>::epsilon() * energy;
    const double variance = std::max(error, floor) / options.samples;
    if (!(variance > 0.0)) break;
    const int order = static_cast<int>(i) + 1;
    if (choice.better(order, variance)) {
      fit.order = order;
      fit.error_variance = variance;
    }
  }
  for (std::size_t i = static_cast<std::size_t>(fit.order); i-- > 0;) {
    double sum = y[i];
    for (std::size_t k = i + 1; k < static_cast<std::size_t>(fit.order); ++k) sum -= L[k * stride + i] * fit.phi[k];
    fit.phi[i] = sum / L[i * stride + i];
  }
  return fit;
}

void covariance_equations(std::span<const double> r, std::int64_t samples, std::span<const Vec3> first,
                          std::span<const Vec3> last, double ridge, NormalEquations& equations) {
  const auto p = static_cast<std::size_t>(equations.regressors());
  TACTOR_DEMAND(r.size() > p && first.size() > p && last.size() > p);
  const auto n = static_cast<double>(samples);
  for (std::size_t j = 0; j <= p; ++j) {
    double head = 0;
    for (std::size_t t = j; t < p; ++t) head += dot(first[t], first[t - j]);
    equations.at(j, 0) = n * r[j] - head;
  }
  for (std::size_t i = 0; i < p; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      equations.at(i + 1, j + 1) = equations.at(i, j) + dot(first[p - 1 - i], first[p - 1 - j]) - dot(last[i], last[j]);
    }
  }
  for (std::size_t i = 0; i <= p; ++i) equations.at(i, i) += ridge * n * r[0];
}

void RecursiveEquations::add(std::span<const Vec3> z) {
  constexpr double drowned = 1e-12;
  // Silence has nothing that could be drowned: it weighs what is remembered, and adds nothing.
  bool silent = true;
  bool heard = false;
  double remembered = 0;
  for (std::size_t i = 0; i < z.size(); ++i) {
    const double energy = dot(z[i], z[i]);
    const double known = equations_.at(i, i);
    silent = silent && energy == 0;
    heard = heard || energy > drowned * known;
    remembered = std::max(remembered, known);
  }
  const bool anew = !silent && !heard;
  // What has faded to where quotients lose their digits is forgotten for good.
  if (anew || !has_energy(remembered, 0)) equations_.clear();
  if (anew) weight_ = 0;
  equations_.add(z, forgetting_);
  weight_ = forgetting_ * weight_ + 1;
}

}  // namespace tactor
