#include "devices/simulated/transmission.hpp"

#include <numbers>

namespace tactor {

TransmissionParameters transmission_of(double mass, double motor_share, double frequency, double damping_ratio,
                                       double backlash) {
  if (frequency <= 0) return {};
  const double motor_mass = motor_share * mass;
  const double reduced_mass = motor_mass * (mass - motor_mass) / mass;
  const double omega = 2 * std::numbers::pi * frequency;
  return {.motor_mass = motor_mass,
          .stiffness = omega * omega * reduced_mass,
          .damping = 2 * damping_ratio * omega * reduced_mass,
          .half_gap = 0.5 * backlash};
}

}  // namespace tactor
