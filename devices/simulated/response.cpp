#include "devices/simulated/response.hpp"

#include <cmath>
#include <numbers>

namespace tactor {

namespace {

using Complex = std::complex<double>;

/// From the commanded force to that of the motors.
Complex actuation(const LinearDevice& device, Complex s) {
  Complex a = std::exp(-s * device.delay);
  if (device.bandwidth > 0) a /= 1.0 + s / (2 * std::numbers::pi * device.bandwidth);
  if (device.hold > 0) a *= (1.0 - std::exp(-s * device.hold)) / (s * device.hold);
  return a;
}

}  // namespace

Complex position_response(const LinearDevice& device, double frequency, ResponsePoint point) {
  const Complex s(0, 2 * std::numbers::pi * frequency);
  const TransmissionParameters& link = device.transmission;
  Complex hand = device.hand_damping * s + device.hand_stiffness;
  double mass = device.mass;
  if (device.grip_stiffness > 0 || device.grip_damping > 0) {
    const Complex grip = device.grip_damping * s + device.grip_stiffness;
    hand += device.hand_mass * s * s;
    hand *= grip / (grip + hand);
    mass -= device.hand_mass;
  }
  const Complex a = actuation(device, s);
  if (link.motor_mass <= 0) return a / (mass * s * s + device.damping * s + hand);
  const Complex coupled = link.damping * s + link.stiffness;
  const Complex motor_side = link.motor_mass * s * s + device.damping * s + coupled;
  const Complex handle = (mass - link.motor_mass) * s * s + hand + coupled;
  return a * (point == ResponsePoint::handle ? coupled : handle) / (motor_side * handle - coupled * coupled);
}

double acceleration_response_dB(const LinearDevice& device, double frequency, ResponsePoint point) {
  const double omega = 2 * std::numbers::pi * frequency;
  return 20 * std::log10(omega * omega * std::abs(position_response(device, frequency, point)));
}

}  // namespace tactor
