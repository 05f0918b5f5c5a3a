#include "nodes/source/tremor.hpp"

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/uniform_real_distribution.hpp>
#include <cmath>
#include <numbers>

namespace tactor {

Tremor::Tremor(double rms, double low, double high, int components, std::uint64_t seed)
    : amplitude_(rms * std::sqrt(2.0 / components)) {
  if (rms == 0) return;
  boost::random::mt19937_64 random(seed);
  boost::random::uniform_real_distribution<double> fraction(0, 1);
  components_.resize(static_cast<std::size_t>(components));
  for (Component& component : components_) {
    for (int axis = 0; axis < 3; ++axis) {
      component.omega[axis] = 2 * std::numbers::pi * (low + (high - low) * fraction(random));
      component.phase[axis] = 2 * std::numbers::pi * fraction(random);
    }
  }
}

Tremor::Value Tremor::at(double t) const {
  Value value;
  for (const Component& component : components_) {
    for (int axis = 0; axis < 3; ++axis) {
      const double angle = component.omega[axis] * t + component.phase[axis];
      value.p[axis] += amplitude_ * std::cos(angle);
      value.v[axis] -= amplitude_ * component.omega[axis] * std::sin(angle);
    }
  }
  return value;
}

}  // namespace tactor
