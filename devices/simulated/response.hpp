// The frequency response of the simulated device's linear part, in closed form.
#pragma once

#include <complex>

#include "devices/simulated/transmission.hpp"

namespace tactor {

/// The linear part of the simulated device along one axis. Friction, cogging, play, limits and encoders are not in it.
struct LinearDevice {
  double hold = 0;            ///< s, for which a command is held: a period of the loop; 0: it changes all the time
  double delay = 0;           ///< s, until a command acts
  double bandwidth = 0;       ///< Hz, of the amplifier; 0: no pole
  double mass = 0;            ///< kg, of motors, handle and hand
  double damping = 0;         ///< N s/m, on the motor side
  double hand_damping = 0;    ///< N s/m, between hand and target
  double hand_stiffness = 0;  ///< N/m, between hand and target
  double hand_mass = 0;       ///< kg, the hand's part of `mass`; counts where there is a grip
  double grip_stiffness = 0;  ///< N/m, between handle and hand; with `grip_damping` 0 as well, the grip is rigid
  double grip_damping = 0;    ///< N s/m, between handle and hand
  TransmissionParameters transmission;  ///< its half gap does not count
};

/// Where the motion is measured.
enum class ResponsePoint {
  handle,      ///< where the hand holds
  motor_side,  ///< where the encoders are
};

/// Position by commanded force, m/N, at `frequency` > 0 in Hz, the hand's target at rest. With s = 2 pi i f:
///   H = A X,   A = e^(-s T_d) / (1 + s / (2 pi B)) (1 - e^(-s T)) / (s T)
/// with the delay T_d, the amplifier's bandwidth B and the hold T. As one body X = 1 / (M s^2 + (b + b_h) s + k_h); as
/// two, X_1 of the motor side and X_2 of the handle solve
///   (m_1 s^2 + (b + c) s + k) X_1 - (c s + k) X_2 = 1
///   (m_2 s^2 + (c + b_h) s + k + k_h) X_2 - (c s + k) X_1 = 0.
/// With a grip M and m_2 are without the hand's mass m_h, and b_h s + k_h gives way to grip and hand in series:
///   1 / (1 / (c_g s + k_g) + 1 / (m_h s^2 + b_h s + k_h)).
/// Velocity by force is s H, acceleration s^2 H.
std::complex<double> position_response(const LinearDevice& device, double frequency, ResponsePoint point);

/// 20 log10 of the acceleration by commanded force, relative to 1 m/s^2 a newton.
double acceleration_response_dB(const LinearDevice& device, double frequency, ResponsePoint point);

}  // namespace tactor
