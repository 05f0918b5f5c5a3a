#include "nodes/prediction/ar_estimator.hpp"

#include <algorithm>

#include "nodes/prediction/burg.hpp"

namespace tactor {

namespace {

// Multiplies every root by 0.98 until all are inside the unit circle; nothing where a hundred times do not suffice.
void shrink(ArFit& fit) {
  constexpr double factor = 0.98;
  for (int i = 0; i < 100 && !is_stable(fit.coefficients()); ++i) {
    double power = 1;
    for (int k = 0; k < fit.order; ++k) fit.phi[static_cast<std::size_t>(k)] *= power *= factor;
  }
  if (!is_stable(fit.coefficients())) fit = {};
}

}  // namespace

ArEstimator::ArEstimator(const ArEstimatorOptions& options) : options_(options) {
  if (options.method == ArMethod::rls) {
    recursion_.emplace(options.max_order, options.forgetting);
  } else {
    window_.emplace(options.window, static_cast<std::size_t>(options.max_order) + 1, options.remove_mean);
  }
}

void ArEstimator::push(const Vec3& x) {
  if (!recursion_) {
    window_->push(x);
    return;
  }
  const std::size_t size = static_cast<std::size_t>(options_.max_order) + 1;
  const std::span<Vec3> z = std::span(recent_).first(size);
  std::copy_backward(z.begin(), z.end() - 1, z.end());
  z[0] = x;
  seen_ = std::min(seen_ + 1, options_.max_order + 1);
  if (seen_ > options_.max_order) recursion_->add(z);
}

double ArEstimator::samples() const {
  return recursion_ ? recursion_->samples() : static_cast<double>(window_->size());
}

ArFit ArEstimator::fit(int order, OrderRule rule, bool& unstable) {
  unstable = false;
  const int highest = std::min(options_.max_order, static_cast<int>(samples() / 3));
  if (highest < std::max(order, 1)) return {};
  const OrderOptions options{
      .max_order = order > 0 ? order : highest, .rule = order > 0 ? OrderRule::highest : rule, .samples = samples()};
  if (!recursion_) return fit_window(options, unstable);
  if (!has_energy(recursion_->energy(), 0)) return {};
  ArFit fit = recursion_->equations().solve(energy_ridge, options);
  unstable = !is_stable(fit.coefficients());
  if (unstable) shrink(fit);
  return fit;
}

ArFit ArEstimator::fit_window(const OrderOptions& options, bool& unstable) {
  constexpr std::size_t most = ArCoefficients::max_order + 1;
  const std::size_t count = static_cast<std::size_t>(options.max_order) + 1;
  std::array<double, most> storage;
  const std::span<double> r = std::span(storage).first(count);
  window_->covariances(r);
  if (!has_energy(r[0], window_->noise())) return {};
  if (options_.method == ArMethod::yule_walker) return fit_yule_walker(r, options);
  std::array<Vec3, most> first_storage;
  std::array<Vec3, most> last_storage;
  const std::span<Vec3> first = std::span(first_storage).first(count);
  const std::span<Vec3> last = std::span(last_storage).first(count);
  window_->edges(first, last);
  const auto n = static_cast<std::int64_t>(window_->size());
  if (options_.method == ArMethod::burg) return fit_burg(r, n, first, last, options);
  NormalEquations equations(options.max_order);
  covariance_equations(r, n, first, last, energy_ridge, equations);
  OrderOptions summed = options;
  summed.samples = static_cast<double>(n - options.max_order);
  const ArFit fit = equations.solve(energy_ridge, summed);
  unstable = !is_stable(fit.coefficients());
  return unstable ? fit_yule_walker(r, options) : fit;
}

}  // namespace tactor
