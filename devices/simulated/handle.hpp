// The handle of a device in a hand: what moves when a force is commanded.
#pragma once

#include "devices/simulated/amplifier.hpp"
#include "devices/simulated/cogging.hpp"
#include "devices/simulated/friction.hpp"
#include "devices/simulated/mass_chain.hpp"
#include "devices/simulated/motion.hpp"
#include "devices/simulated/step_cache.hpp"
#include "devices/simulated/transmission.hpp"

namespace tactor {

/// The constants of one kind of motion, translation or rotation (kg, N s/m, N/m, N, m/s, or kg m^2, N m s/rad, N m/rad,
/// N m, rad/s).
struct HandleParameters {
  double inertia = 0;            ///< of all that moves: motors, handle and hand
  double damping = 0;            ///< viscous, of the device against the world
  double coulomb = 0;            ///< friction of the device against the world
  double hand_damping = 0;       ///< between hand and target
  double hand_stiffness = 0;     ///< between hand and target
  double breakaway = 0;          ///< friction at rest, where it is above `coulomb`
  double stribeck_velocity = 0;  ///< by which most of the difference is gone
  double hand_inertia = 0;       ///< the hand's part of `inertia`, above 0 where there is a grip
  double grip_stiffness = 0;     ///< between handle and hand; with `grip_damping` 0 as well, the grip is rigid
  double grip_damping = 0;       ///< between handle and hand

  [[nodiscard]] bool has_grip() const { return grip_stiffness > 0 || grip_damping > 0; }
};

/// What makes a device less than ideal. As they are here, all of them are off.
struct DeviceParts {
  AmplifierParameters amplifier;
  CoggingParameters cogging;            ///< of the translation
  TransmissionParameters transmission;  ///< of the translation
};

/// Handle and hand, driven by a commanded wrench u that is held over a step, and by the hand towards its target T. The
/// amplifiers make the motors' force f of u (see `Amplifier`). Without a transmission all is one body:
///   M a = f - b v - friction(v) + cogging(x) + b_h (v_T - v) + k_h (x_T - x).
/// With one, motors and handle are two (see `MassChain`): motors, friction, damping and cogging act on the motor
/// side, the hand on the handle, whose mass is `inertia` less that of the motor side.
/// With a grip the hand is a body of its own behind handle and grip: target - hand - handle (- motors). The grip is
/// not bent where handle and hand are at one place.
/// Rotation has the form of one body, with the rotation vector from handle to target and a scalar inertia; it has
/// neither cogging nor transmission. With a grip it has two, and the rotation vector from handle to hand. Both vectors
/// are followed beyond half a turn, so that a spring that is wound up pulls back and not on.
/// The hand: 0.55 kg, 6.5 N s/m, 135 N/m are usual values of a grip on a haptic handle.
///
/// Integration, in steps of h: the linear part exactly, for the target of mid-step (error of order h^2), and for the
/// motors' mean force over the step (exact where they have no pole, else error of order h^2); friction and cogging as
/// impulses of h/2 before and after it (Strang splitting, error of order h^2), of which that of friction at most brings
/// the body to rest; a body at rest stays for a step where the force on it is at most its friction, so that it breaks
/// away up to h late. One body with Coulomb friction alone counts as at rest only when a step ends so: one that stops
/// under a force f between half its friction and all of it creeps on by f h / (2 M), 4 um/s at most with the defaults.
/// With breakaway friction, cogging, a transmission or a grip it stays. Stable for any constants.
class Handle {
 public:
  /// `sub_step` is the longest h in s; fast cogging and the contacts of a gap take shorter ones.
  Handle(const HandleParameters& translation, const HandleParameters& rotation, double sub_step, bool rotate,
         const DeviceParts& parts = {});

  void place(const MotionState& state);
  /// Moves on by `dt` s under the commanded wrench, while the target moves from `from` to `to`.
  void advance(double dt, const Wrench& commanded, const MotionState& from, const MotionState& to);
  /// Only the amplifiers move on: what becomes of the handle is not known here.
  void advance_amplifier(double dt, const Wrench& commanded);

  /// Where the hand holds.
  [[nodiscard]] const MotionState& state() const { return state_; }
  /// Where encoders and motors are; the same where there is no transmission.
  [[nodiscard]] const MotionState& motor_side() const { return motor_; }
  /// The hand itself; the same as `state` where the grip is rigid.
  [[nodiscard]] const MotionState& hand() const { return hand_; }
  [[nodiscard]] const Amplifier& amplifier() const { return amplifier_; }
  /// J, that the motors have given to the device so far, net.
  [[nodiscard]] double work() const { return work_; }

 private:
  /// The exact step of M a = f - B v - K x from x = 0: x' = x_v v + x_f f, v' = v_v v + v_f f.
  struct Propagator {
    double x_v = 0, x_f = 0, v_v = 0, v_f = 0;
  };
  struct Propagators {
    Propagator translate, rotate;
  };
  static Propagator make_propagator(const HandleParameters& coupling, double h);
  /// One step from `x`; `v` is the velocity before and after, the result the way moved.
  static Vec3 move(const HandleParameters& coupling, const Friction& friction, const Cogging* cogging,
                   const Propagator& by, double h, const Vec3& f, const Vec3& x, Vec3& v);
  void translate(double h, const Propagator& by, const Vec3& motor_F_W, const MotionState& target);
  void translate_bodies(double h, const Vec3& motor_F_W, const Vec3& hand_F_W);
  void turn(double h, const Propagator& by, const Vec3& motor_T_W, const MotionState& target);
  void turn_in_grip(double h, const Vec3& motor_T_W, const Vec3& hand_T_W);

  HandleParameters translation_;
  HandleParameters rotation_;
  double sub_step_;
  bool rotate_;
  Amplifier amplifier_;
  Friction friction_;
  Friction friction_angle_;
  Cogging cogging_;
  bool has_transmission_;
  MassChain<2> two_;      // motors and handle, or handle and hand
  MassChain<3> three_;    // motors, handle and hand
  MassChain<2> turning_;  // rotation of handle and hand
  StepCache<Propagators> propagators_;
  MotionState state_;
  MotionState motor_;
  MotionState hand_;
  Vec3 grip_W_;  // rad, from handle to hand
  Vec3 arc_W_;   // rad, from hand to target
  double work_ = 0;
};

}  // namespace tactor
