// The transmission of a device: motors and handle are two masses with a spring, and perhaps play, between them.
#pragma once

namespace tactor {

/// What lies between the motors, where the encoders sit, and the handle, where the hand holds.
struct TransmissionParameters {
  double motor_mass = 0;  ///< kg, of the motors as felt at the handle; 0: there is no transmission, all moves as one
  double stiffness = 0;   ///< N/m, of the spring
  double damping = 0;     ///< N s/m, of the damper beside it
  double half_gap = 0;    ///< m, of the play to each side, of every axis
};

/// The transmission of a device of the mass `mass` (kg), of which the share `motor_share` in (0, 1) sits on the motor
/// side, whose two masses swing against each other, free at both ends and without the hand, with the frequency
/// `frequency` (Hz, undamped) and the damping ratio `damping_ratio`: with the reduced mass
///   mu = m_1 m_2 / (m_1 + m_2):   k = (2 pi f)^2 mu,   c = 2 zeta (2 pi f) mu.
/// Where the frequency is 0 there is none.
TransmissionParameters transmission_of(double mass, double motor_share, double frequency, double damping_ratio,
                                       double backlash);

}  // namespace tactor
