// The energy that a hand has given to a device through its handle, counted from what the device shows and commands.
#pragma once

#include <cstdint>

#include "framework/core/messages.hpp"
#include "nodes/passivity/port_samples.hpp"

namespace tactor {

/// A small motion of the handle, in W: m, and rad as a rotation vector.
struct SmallMotion {
  Vec3 x;
  Vec3 r;
};

/// J, that a wrench gives to what moves.
inline double work(const Wrench& wrench, const SmallMotion& motion) {
  return dot(wrench.force, motion.x) + dot(wrench.torque, motion.r);
}

/// How the energy is counted.
struct PortEnergyOptions {
  double step = 0;          ///< m, of the position encoders
  double step_angle = 0;    ///< rad, of the angle encoders
  double pessimism = 0;     ///< share of the worst case of their rounding that is taken off
  double acceleration = 0;  ///< m/s^2, the greatest of the handle
  Duration tick;            ///< of the device; zero: its commands act until the next one
  double damping = 0;       ///< N s/m, of the device against the world; what it takes is added
  double start = 0;         ///< J, at the begin
  double kept = 0;          ///< J, that are kept at any force
  double stiffness = 0;     ///< N/m, above 0, of the softest spring that is displayed
  Vec3 weight_W;            ///< N, of the tool: a motion along it gives that energy to what is displayed
  double lever = 0;         ///< m, above 0: an angle counts as this times as much way, a torque as its part of a force
  bool torque = true;       ///< false: the scene has none
};

/// E(n) = E(n-1) - F(n-1) . (x(n) - x(n-1)) + b |x(n) - x(n-1)|^2 / T(n): what the hand has given against the wrench F
/// that was commanded at tick n-1 and held since, and what the device's own damping b has taken at least (of all
/// motions over that way in that time T(n) the even one loses least). Torque likewise, with the rotation vector of
/// R(n) R(n-1)^T and b lever^2; one sum for both, because a coupling may take energy in by pushing and give it back by
/// turning.
///
/// Rounding: x(n) is a measurement, off by up to a half of the encoder's step D on each axis. By parts, the sum of
/// F(n-1) . (x(n) - x(n-1)) is off by at most D/2 (|F(0)| + sum |F(n) - F(n-1)| + |F(n)|), in 1-norms. `pessimism`
/// times D/2 |F(n) - F(n-1)| is taken off at each change.
///
/// Cap: what a dissipating motion piled up long ago must not be spent later. A spring of the stiffness k that pushes
/// with F holds F^2 / (2 k), so no passive spring stiffer than `stiffness` gives back more than that. E stays at kept +
/// (|F|^2 + |torque / lever|^2) / (2 stiffness) at most; `kept` is for what bodies have in motion.
///
/// Weight: a tool of the weight w that goes down gives w . (x(n) - x(n-1)), which the hand has put in by lifting it, or
/// which was there at the begin. It is counted by the way of the handle, while something is commanded, so that no
/// closed path gains from it.
///
/// Late: a device lets go of a command that it has not renewed for two ticks. Over a longer way the energy of these two
/// is taken from the velocity that the handle had, with what it may have gone faster.
///
/// The equation holds where the wrench acts from tick to tick and where it is commanded: amplifiers without lag, lines
/// without delay.
class PortEnergy {
 public:
  explicit PortEnergy(const PortEnergyOptions& options) : options_(options), energy_(options.start) {}

  /// Takes what has come at the two inputs of a stage, in the order of its times. What is not finite, or earlier than
  /// what was taken before, is left out.
  void take(Input<DeviceState>& device, Input<Wrench>& commanded);

  /// True when a state has come.
  [[nodiscard]] bool started() const { return samples_.started(); }
  /// Of the newest state.
  [[nodiscard]] Time at() const { return samples_.newest().stamp.valid; }
  /// J, at the newest state.
  [[nodiscard]] double energy() const { return energy_; }
  /// The least that it has been.
  [[nodiscard]] double least() const { return least_; }
  /// J, the strict bound so far: max |F| D + max |F . dx| over the ticks.
  [[nodiscard]] double strict_bound() const { return of_rounding_ + of_tick_; }
  /// Commanded now, without the tool's weight.
  [[nodiscard]] Wrench held() const { return without_weight(held_); }
  /// The part of a wrench whose energy is counted: without the tool's weight; zero stays zero.
  [[nodiscard]] Wrench without_weight(const Wrench& wrench) const;
  /// Of the handle as the device shows it, which filters and is late; m/s and rad/s.
  [[nodiscard]] const Twist& velocity() const { return velocity_; }
  /// The mean velocity from the state before to the newest, by their positions, and the time between them (s).
  [[nodiscard]] const Twist& mean_velocity() const { return mean_velocity_; }
  [[nodiscard]] double mean_over() const { return mean_over_; }

 private:
  void take_state(const Stamped<DeviceState>& state);
  [[nodiscard]] double given(const SmallMotion& way, double dt) const;
  void hold(const Wrench& wrench);
  [[nodiscard]] double most() const;

  PortEnergyOptions options_;
  PortSamples samples_;
  Twist velocity_, mean_velocity_;
  double mean_over_ = 0;
  Wrench held_;
  double energy_ = 0;
  double least_ = 0;
  double of_rounding_ = 0, of_tick_ = 0;  // J, the two parts of the strict bound
};

}  // namespace tactor
