// The amplifiers and motors of a device: what force they give when one is commanded.
#pragma once

#include "framework/core/spatial.hpp"

namespace tactor {

struct AmplifierParameters {
  double bandwidth = 0;   ///< Hz, where the pole has taken 3 dB; usual: 100 Hz to 2 kHz; 0: no pole
  double force_max = 0;   ///< N, the largest motor force, by norm; 0: none
  double torque_max = 0;  ///< N m, the largest motor torque, by norm; 0: none
};

/// A first-order pole, then saturation:
///   df/dt = 2 pi B (u - f),   F = f min(1, F_max / |f|),
/// with the commanded wrench u, the bandwidth B and the motors' wrench F, all in W, on the device. Force and torque
/// have the same pole and a limit each.
///
/// The limit is by norm and keeps the direction, as those of the safety gate and of the devices of hardware do. A limit
/// per motor would need the device's joints, which this model does not have.
class Amplifier {
 public:
  explicit Amplifier(const AmplifierParameters& parameters);

  /// Moves on by `h` s > 0 while `commanded` is held. Returns the mean wrench of the motors over that time: exact for
  /// the pole; the limit acts on the mean, which is wrong by order h^2 where it is reached within the step.
  Wrench advance(double h, const Wrench& commanded) noexcept;
  /// The motors' wrench at this instant.
  [[nodiscard]] Wrench output() const noexcept { return limited_to_motors(state_); }
  /// True where the last step reached a limit.
  [[nodiscard]] bool saturated() const noexcept { return saturated_; }

 private:
  [[nodiscard]] Wrench limited_to_motors(const Wrench& wrench) const noexcept;

  AmplifierParameters parameters_;
  Wrench state_;        // behind the pole, before the limit
  double h_ = 0;        // the step that the following are for
  double decay_ = 0;    // what is left after h of a difference between commanded and given
  double average_ = 1;  // its mean over h
  bool saturated_ = false;
};

}  // namespace tactor
