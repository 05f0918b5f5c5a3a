// Nearest-rank quantiles.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace tactor::bench {

/// The q-quantile of the values, 0 of none: the smallest value that a share q of them does not exceed.
inline double quantile(std::vector<double> values, double q) {
  if (values.empty()) return 0;
  const auto rank = static_cast<std::ptrdiff_t>(std::ceil(q * static_cast<double>(values.size())));
  const auto place = values.begin() + std::clamp<std::ptrdiff_t>(rank - 1, 0, std::ssize(values) - 1);
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

}  // namespace tactor::bench
