// Burg's method: auto-regressive coefficients that minimise forward and backward errors together.
#pragma once

#include "nodes/prediction/autoregression.hpp"

namespace tactor {

/// Burg's coefficients of N vector samples x_0 .. x_{N-1}: with forward errors f and backward errors b of the model of
/// order m, the next reflection coefficient is
///   k = 2 sum_t f_t . b_{t-1} / sum_t (|f_t|^2 + |b_{t-1}|^2),   t = m + 1 .. N - 1,
/// scalar products over the axes, so |k| <= 1 by construction and a rotation changes nothing. The errors are never
/// formed: the two sums are quadratic forms of the model in sums of products, which change from order to order by the
/// samples at the edges alone. So a fit takes O(p^2), whatever N is, where the sums are there.
/// `r`: autocovariance() of the samples, more than max_order lags; `first[i]` = x_i and `last[i]` = x_{N-1-i}, more
/// than max_order of each; all about the same mean. The energy of the forms is raised by the share energy_ridge, which
/// keeps |k| < 1 under rounding. Ends early as fit_yule_walker() does. Throws nothing, allocates nothing.
/// Sources: Burg, "Maximum entropy spectral analysis", 1967; Vos, "A fast implementation of Burg's method", 2013.
ArFit fit_burg(std::span<const double> r, std::int64_t samples, std::span<const Vec3> first, std::span<const Vec3> last,
               const OrderOptions& options);

}  // namespace tactor
