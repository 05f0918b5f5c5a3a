// The transmission of a device: motors and handle are two masses with a spring, and perhaps play, between them.
#pragma once

#include <array>

#include "devices/simulated/cogging.hpp"
#include "devices/simulated/friction.hpp"
#include "framework/core/spatial.hpp"

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

/// Position (m) and velocity (m/s) of a point in W.
struct PointState {
  Vec3 p;
  Vec3 v;
};

/// Two masses on each axis of W, with x_1, v_1 of the motor side and x_2, v_2 of the handle:
///   m_1 a_1 = f_1 - b v_1 - friction(v_1) + cogging(x_1) + s
///   m_2 a_2 = f_2 - B v_2 - K (x_2 - x_2(0)) - s
///   s = k (d - g sign d) + c (v_2 - v_1) where |d| > g, else 0;   d = x_2 - x_1,
/// with the half gap g, the motors' force f_1 and the hand's f_2. Inside the gap neither side feels the other. The
/// damper may pull a little just before the contact opens.
///
/// A step of h: half of friction and cogging as impulses, the linear part exactly by the matrix exponential, the other
/// half (Strang splitting): an error of order h^2, and none where both are zero and there is no gap. An axis that
/// enters or leaves its gap within a step is stepped in halves of halves, down to h/256, so that it changes at most
/// h/256 late; a contact that opens and closes again within h/2^n of an undivided step is not seen. Motors at rest,
/// or that the first half of the friction brings to rest, stay for the step where the force on them is at most the
/// friction. Stable for any constants, since each part is.
class Transmission {
 public:
  /// `damping` b; `hand_stiffness` K and `hand_damping` B act on the handle, of `handle_mass`. `motor_friction` and
  /// `cogging` act on the motor side.
  struct Parameters {
    TransmissionParameters link;
    double damping = 0;
    double handle_mass = 0;
    double hand_stiffness = 0;
    double hand_damping = 0;
  };
  Transmission(const Parameters& parameters, const Friction& motor_friction, const Cogging& cogging);

  /// The longest step (s) that sees the contacts of its gap; no bound where there is none.
  [[nodiscard]] double longest_step() const;
  /// Moves both sides on by `h` s under `motor_F_W`, while the hand pulls with `hand_F_W` at the handle's present
  /// place.
  void advance(double h, const Vec3& motor_F_W, const Vec3& hand_F_W, PointState& motor, PointState& handle) noexcept;
  /// The spring's and damper's force on the motor side, in W.
  [[nodiscard]] Vec3 link_force(const PointState& motor, const PointState& handle) const noexcept;

 private:
  static constexpr int finest = 8;  // halvings of a step
  /// y_1, v_1, y_2, v_2 (rows) after a step from y = 0, by v_1, v_2, f_1, f_2 (columns).
  using Propagator = std::array<std::array<double, 4>, 4>;
  using Levels = std::array<Propagator, finest + 1>;  // of h, h/2, h/4, ...
  struct Axis {
    double x_1, v_1, x_2, v_2;
  };

  void prepare(double h) noexcept;
  void make_levels(bool held, bool touching, Levels& levels) const noexcept;
  [[nodiscard]] double side_of(double d) const noexcept;
  void step(Axis& axis, const Propagator& by, double side, double motor_f, double hand_f, double start) const noexcept;
  void advance_axis(Axis& axis, bool held, double motor_f, double hand_f) const noexcept;

  Parameters parameters_;
  Friction friction_;
  Cogging cogging_;
  double h_ = 0;  // the step that the propagators are for
  // By what the motor side does (0: it moves, 1: friction holds it) and the spring (0: in the gap, 1: it touches).
  std::array<std::array<Levels, 2>, 2> levels_{};
};

}  // namespace tactor
