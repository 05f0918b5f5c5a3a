#include "nodes/prediction/burg.hpp"
#include "nodes/prediction/ar_coefficients.hpp"

#include <cmath>

namespace tactor {

ArFit fit_burg(std::span<const double> r, std::int64_t samples, std::span<const Vec3> first, std::span<const Vec3> last,
               const OrderOptions& options) {
  const auto top = static_cast<std::size_t>(options.max_order);
  TACTOR_DEMAND(options.max_order >= 1 && options.max_order <= ArCoefficients::max_order);
  TACTOR_DEMAND(r.size() > top && first.size() > top && last.size() > top);
  const auto n = static_cast<double>(samples);
  constexpr std::size_t storage = ArCoefficients::max_order + 2;
  // With a = (1, -phi_1, ..., -phi_m, 0) and R_ij = sum_{t=m+1}^{N-1} x_{t-i} . x_{t-j} + x_{t-m-1+i} . x_{t-m-1+j}:
  // sum |f|^2 + |b|^2 = a R a, 2 sum f b = a R (a reversed). g = R a is carried from order to order.
  std::array<double, storage> a{};
  std::array<double, storage> g{};
  std::array<double, storage> row{};  // the row of R that the next order adds
  a[0] = 1;
  g[0] = 2 * n * r[0] * (1.0 + energy_ridge) - dot(first[0], first[0]) - dot(last[0], last[0]);
  g[1] = row[0] = 2 * n * r[1];
  OrderChoice choice(options);
  ArFit model;
  model.error_variance = r[0] * (1.0 + energy_ridge);
  ArFit best;
  for (std::size_t m = 0;; ++m) {
    double energy = 0;
    double product = 0;
    for (std::size_t i = 0; i <= m + 1; ++i) {
      energy += a[i] * g[i];
      product += a[m + 1 - i] * g[i];
    }
    const double reflection = product / energy;
    if (!(energy > 0.0) || !(std::abs(reflection) < 1.0)) break;
    step_up(model, reflection);
    model.error_variance *= (1.0 - reflection) * (1.0 + reflection);
    if (!(model.error_variance > 0.0)) break;
    if (choice.better(model.order, model.error_variance)) best = model;
    if (m + 1 == top) break;
    const std::array<double, storage> a_old = a;
    const std::array<double, storage> g_old = g;
    for (std::size_t i = 0; i <= m + 1; ++i) {
      a[i] = a_old[i] - reflection * a_old[m + 1 - i];
      g[i] = g_old[i] - reflection * g_old[m + 1 - i];
    }
    // R of the next order lacks the products of the first forward and of the last backward error.
    Vec3 forward;
    Vec3 backward;
    for (std::size_t i = 0; i <= m + 1; ++i) {
      forward += a[i] * first[m + 1 - i];
      backward += a[i] * last[m + 1 - i];
    }
    for (std::size_t i = 0; i <= m + 1; ++i) g[i] -= dot(first[m + 1 - i], forward) + dot(last[m + 1 - i], backward);
    for (std::size_t j = m + 1; j > 0; --j) {
      row[j] = row[j - 1] - dot(last[j - 1], last[m + 1]) - dot(first[m + 1], first[j - 1]);
    }
    row[0] = 2 * n * r[m + 2];
    g[m + 2] = 0;
    for (std::size_t j = 0; j <= m + 1; ++j) g[m + 2] += row[j] * a[j];
  }
  return best;
}

}  // namespace tactor
