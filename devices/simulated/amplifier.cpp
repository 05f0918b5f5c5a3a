#include "devices/simulated/amplifier.hpp"

#include <cmath>
#include <numbers>

namespace tactor {

Amplifier::Amplifier(const AmplifierParameters& parameters) : parameters_(parameters) {}

Wrench Amplifier::limited_to_motors(const Wrench& wrench) const noexcept {
  Wrench result = wrench;
  if (parameters_.force_max > 0) result.force = limited(wrench.force, parameters_.force_max);
  if (parameters_.torque_max > 0) result.torque = limited(wrench.torque, parameters_.torque_max);
  return result;
}

Wrench Amplifier::advance(double h, const Wrench& commanded) noexcept {
  Wrench mean = commanded;
  if (parameters_.bandwidth > 0) {
    if (h != h_) {
      h_ = h;
      const double turn = 2 * std::numbers::pi * parameters_.bandwidth * h;
      decay_ = std::exp(-turn);
      average_ = -std::expm1(-turn) / turn;
    }
    const Wrench behind = state_ - commanded;
    mean = commanded + average_ * behind;
    state_ = commanded + decay_ * behind;
  } else {
    state_ = commanded;
  }
  saturated_ = (parameters_.force_max > 0 && norm(mean.force) > parameters_.force_max) ||
               (parameters_.torque_max > 0 && norm(mean.torque) > parameters_.torque_max);
  return limited_to_motors(mean);
}

}  // namespace tactor
