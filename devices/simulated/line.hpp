// The line between the host and the simulated device: its delays, and the energy that the host counts on it.
#pragma once

#include "devices/simulated/line_delay.hpp"
#include "devices/simulated/motion.hpp"
#include "framework/core/spatial.hpp"
#include "framework/realtime/line_energy.hpp"

namespace tactor {

/// What the encoders show, on its way to the host.
struct ShownMotion {
  MotionState motion;
  Time read;
};

/// Once a tick a motion comes out at the host, and a wrench at the motors. The host counts the energy of both at its
/// end, and bounds it where that is asked for (see LineEnergy), with the delays that it knows.
class SimulatedLine {
 public:
  /// Both delays in ticks. `weight_W` is the tool's, N; `rotates` false: the scene has no torque.
  SimulatedLine(std::size_t ticks_in, std::size_t ticks_out, const LineEnergyOptions& energy, const Vec3& weight_W,
                bool rotates);

  /// All that is on the way to the host becomes that.
  void fill(const ShownMotion& shown) { in_.fill(shown); }
  /// What the host gets at a tick at which the encoders show that; `counts` false: no energy is counted.
  MotionState receive(const ShownMotion& shown, bool counts);
  /// The host sends a wrench, of which `gain` times the tool's weight is a part, 0 to 1. The motors have `held` from
  /// then on.
  void send(Time now, const Wrench& commanded_D_W, double gain, bool counts);
  /// The motors have nothing any more from that time on, and nothing is on the way to them.
  void let_go(Time at);

  /// What the motors have since the last tick.
  [[nodiscard]] const Wrench& held() const { return held_D_W_; }
  /// True where they have a force, or one is on its way.
  [[nodiscard]] bool acts() const;
  [[nodiscard]] LineTotals totals() const { return energy_.totals(); }

 private:
  void count(const ShownMotion& came);

  const Vec3 weight_W_;
  const bool rotates_;
  LineEnergy energy_;
  LineDelay<ShownMotion> in_;
  LineDelay<Wrench> out_;
  Wrench held_D_W_;
  bool any_ = false;
  ShownMotion counted_;  // the newest
  Vec3 turned_W_;        // rad, the small rotations of the handle so far
};

}  // namespace tactor
