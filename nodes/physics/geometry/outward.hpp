// Doubles to floats that bound them.
#pragma once

#include <cmath>
#include <limits>

namespace tactor {

/// The largest float that is not above v.
inline float rounded_down(double v) {
  const auto f = static_cast<float>(v);
  return f > v ? std::nextafter(f, -std::numeric_limits<float>::infinity()) : f;
}
/// The smallest float that is not below v.
inline float rounded_up(double v) {
  return -rounded_down(-v);
}

}  // namespace tactor
