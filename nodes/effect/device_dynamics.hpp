// How the handle of a device moves when a force is commanded tick by tick, and which forces make it move as wanted.
#pragma once

#include <vector>

namespace tactor {

/// The linear part of a device in a hand, along one axis. Friction, play, cogging, limits and delays are not in it.
struct DeviceDynamics {
  double mass = 0;                 ///< kg, of motors and handle
  double damping = 0;              ///< N s/m, on the motor side
  double hand_mass = 0;            ///< kg
  double hand_damping = 0;         ///< N s/m, between handle and a hand's target that stays where it is
  double hand_stiffness = 0;       ///< N/m, likewise
  double grip_stiffness = 0;       ///< N/m, between handle and hand; with `grip_damping` 0 as well, they are one
  double grip_damping = 0;         ///< N s/m, between handle and hand
  double amplifier_bandwidth = 0;  ///< Hz, of a first-order pole; 0: none
  double mode_frequency = 0;       ///< Hz, with which motor side and handle swing without the hand; 0: they are one
  double mode_damping = 0;         ///< ratio, of that mode
  double motor_share = 0.5;        ///< of `mass` on the motor side, where there is a mode
};

/// The mean acceleration of the handle over tick n, (v(nT + T) - v(nT)) / T in m/s^2, when 1 N is commanded for tick 0
/// alone, from rest. Exact for the linear device: with the motors' force f,
///   f' = 2 pi B (u - f),
///   one body:   M x'' = f - (b + b_h) x' - k_h x,
///   two bodies: m_1 x_1'' = f - b x_1' + s,  m_2 x_2'' = -s - b_h x_2' - k_h x_2,  s = k (x_2 - x_1) + c (x_2' -
///   x_1'), with m_1 the motor share and m_2 the rest and the hand, and k = (2 pi f_m)^2 mu, c = 2 zeta (2 pi f_m) mu,
///   where mu is the reduced mass of motor side and handle without the hand.
/// With a grip M and m_2 are without the hand's mass m_h, which is above 0, and instead of b_h and k_h they feel
///   g = k_g (x_h - x) + c_g (x_h' - x'),  m_h x_h'' = -g - b_h x_h' - k_h x_h.
/// `tick` in s.
std::vector<double> tick_response(const DeviceDynamics& device, double tick, std::size_t ticks);

/// Forces for accelerations.
struct AccelerationMatch {
  std::vector<double> force;  ///< N, of each tick, those too in which it fades out
  double error = 0;           ///< RMS of what the linear device misses of `wanted`, as a share of the RMS wanted
};

/// The forces u that make the mean accelerations of the ticks `wanted` (m/s^2), by least squares:
///   sum (a_n - sum h_{n-m} u_m)^2 + (effort / M)^2 sum u_m^2,
/// h the tick response and M all that moves. The sum goes on for `fade` ticks behind `wanted`, with a_n = 0 there. What
/// u is left there holds the hand where it has come to. It is multiplied by a straight line that falls to zero over
/// these ticks, and the hand goes back. `effort` > 0 bounds what is spent on accelerations that the device hardly
/// makes: those above its mode, or within a tick behind its amplifier. After K. Kuchenbecker, J. Fiene, G. Niemeyer,
/// "Improving contact realism through event-based haptic feedback", 2006, who invert a model of their device.
AccelerationMatch match_acceleration(const DeviceDynamics& device, double tick, const std::vector<double>& wanted,
                                     double effort, std::size_t fade);

/// Per m/s of impact, what a decaying sinusoid asks of each tick: the mean over tick n, in 1/s, of
///   a(t) = amplitude exp(-t / decay) sin(2 pi frequency t).
std::vector<double> decaying_sinusoid(double amplitude, double frequency, double decay, double tick, std::size_t ticks);

}  // namespace tactor
