// The energy of a handle in a hand, by a sum over its parts.
#pragma once

#include <algorithm>
#include <cmath>

#include "devices/simulated/handle.hpp"

namespace tactor::test {

/// J, of the translation: of what moves, of the springs of transmission, grip and hand, whose target rests at the
/// origin, and of the cogging.
inline double stored_energy(const Handle& handle, const HandleParameters& of, const DeviceParts& parts = {}) {
  const auto square = [](const Vec3& v) { return dot(v, v); };
  const MotionState &motor = handle.motor_side(), &grip = handle.state(), &hand = handle.hand();
  const TransmissionParameters& link = parts.transmission;
  const double hand_mass = of.has_grip() ? of.hand_inertia : 0;
  double twice = link.motor_mass * square(motor.V.v) + (of.inertia - hand_mass - link.motor_mass) * square(grip.V.v) +
                 hand_mass * square(hand.V.v) + of.grip_stiffness * square(hand.X.p - grip.X.p) +
                 of.hand_stiffness * square(hand.X.p);
  for (int axis = 0; axis < 3; ++axis) {
    const double bent = std::max(std::abs(grip.X.p[axis] - motor.X.p[axis]) - link.half_gap, 0.0);
    twice += link.stiffness * bent * bent;
  }
  return 0.5 * twice + Cogging(parts.cogging).energy(motor.X.p);
}

}  // namespace tactor::test
