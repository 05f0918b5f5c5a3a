#include "nodes/prediction/part_estimator.hpp"

#include <algorithm>

#include "nodes/prediction/whittle.hpp"

namespace tactor {

PartEstimator::PartEstimator(const ArEstimatorOptions& options, ModelStructure model_structure)
    : options_(options), model_structure_(model_structure) {
  models_.reserve(kept);
  if (model_structure == ModelStructure::vector) {
    TACTOR_DEMAND(options.method == ArMethod::yule_walker && options.max_order <= ArCoefficients::max_vector_order);
    samples_.emplace(options.window);
    ordered_.resize(options.window);
    return;
  }
  const int streams = model_structure == ModelStructure::per_axis ? 3 : 1;
  for (int i = 0; i < streams; ++i) estimators_.emplace_back(options);
}

void PartEstimator::push(const Vec3& x) {
  if (samples_) {
    samples_->push(x);
  } else if (model_structure_ == ModelStructure::per_axis) {
    for (int axis = 0; axis < 3; ++axis) estimators_[static_cast<std::size_t>(axis)].push({x[axis], 0, 0});
  } else {
    estimators_.front().push(x);
  }
}

void PartEstimator::drop_oldest() {
  if (samples_) samples_->drop_oldest();
  for (ArEstimator& estimator : estimators_) estimator.drop_oldest();
}

double PartEstimator::samples() const {
  return samples_ ? static_cast<double>(samples_->size()) : estimators_.front().samples();
}

int PartEstimator::fit(int order, OrderRule rule, double hold, std::array<double, ArCoefficients::capacity>& phi,
                       double& variance) {
  phi.fill(0);
  variance = 0;
  const int fitted = samples_ ? fit_vector(order, rule, phi, variance) : fit_axes(order, rule, hold, phi, variance);
  if (fitted > 0) keep(fitted, phi);
  return fitted;
}

int PartEstimator::fit_axes(int order, OrderRule rule, double hold, std::array<double, ArCoefficients::capacity>& phi,
                            double& variance) {
  int highest = 0;
  std::array<int, 3> orders{};
  for (std::size_t axis = 0; axis < estimators_.size(); ++axis) {
    bool unstable = false;
    const ArFit fit = estimators_[axis].fit(order, rule, unstable);
    unstable_ += unstable;
    std::copy_n(fit.phi.begin(), fit.order,
                phi.begin() + static_cast<std::ptrdiff_t>(axis) * ArCoefficients::max_order);
    variance += fit.error_variance;
    orders[axis] = fit.order;
    highest = std::max(highest, fit.order);
  }
  if (highest > 0) {
    for (std::size_t axis = 0; axis < estimators_.size(); ++axis) {
      if (orders[axis] == 0) phi[axis * ArCoefficients::max_order] = hold;
    }
  }
  return highest;
}

int PartEstimator::fit_vector(int order, OrderRule rule, std::array<double, ArCoefficients::capacity>& phi,
                              double& variance) {
  const std::size_t n = samples_->size();
  const int highest = std::min(options_.max_order, static_cast<int>(n / 9));
  if (highest < std::max(order, 1)) return 0;
  for (std::size_t i = 0; i < n; ++i) ordered_[i] = (*samples_)[n - 1 - i];
  const Vec3 level = options_.remove_mean ? mean(*samples_, n) : Vec3{};
  double energy = 0;
  for (std::size_t i = 0; i < n; ++i) energy += dot(ordered_[i] - level, ordered_[i] - level);
  const double rounding = static_cast<double>(n) * std::numeric_limits<double>::epsilon();
  if (!has_energy(energy / static_cast<double>(n), rounding * rounding * dot(level, level))) return 0;
  const VectorArFit fit = fit_whittle(std::span<const Vec3>(ordered_).first(n), level,
                                      {.max_order = order > 0 ? order : highest,
                                       .rule = order > 0 ? OrderRule::highest : rule,
                                       .samples = static_cast<double>(n)});
  std::copy_n(fit.phi.begin(), 9 * fit.order, phi.begin());
  variance = fit.error_variance;
  return fit.order;
}

void PartEstimator::keep(int order, const std::array<double, ArCoefficients::capacity>& phi) {
  if (fits_++ % stride_ != 0) return;
  if (models_.size() == kept) {
    for (std::size_t i = 0; 2 * i < kept; ++i) models_[i] = models_[2 * i];
    models_.resize(kept / 2);
    stride_ *= 2;
  }
  models_.push_back({order, phi});
}

std::vector<double> PartEstimator::spectral_radii() const {
  std::vector<double> radii;
  for (const Kept& model : models_) {
    const std::span<const double> phi(model.phi);
    const auto order = static_cast<std::size_t>(model.order);
    double radius = 0;
    if (model_structure_ == ModelStructure::vector) {
      radius = spectral_radius(phi.first(9 * order), 3);
    } else {
      for (std::size_t axis = 0; axis < estimators_.size(); ++axis) {
        radius = std::max(radius, spectral_radius(phi.subspan(axis * ArCoefficients::max_order, order), 1));
      }
    }
    radii.push_back(radius);
  }
  return radii;
}

}  // namespace tactor
