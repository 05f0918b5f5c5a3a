// The handle of a device in a hand: what moves when a force is commanded.
#pragma once

#include "devices/simulated/motion.hpp"

namespace tactor {

/// The constants of one kind of motion, translation or rotation (kg, N s/m, N/m, N, or kg m^2, N m s/rad, N m/rad, N
/// m).
struct HandleParameters {
  double inertia = 0;         ///< of handle and hand, which move as one
  double damping = 0;         ///< viscous, of the handle against the world
  double coulomb = 0;         ///< friction of the handle against the world
  double hand_damping = 0;    ///< between handle and target
  double hand_stiffness = 0;  ///< between handle and target
};

/// Handle and hand as one body, driven by a force u that is held over a step, and by the hand towards its target T:
///   M a = u - b v - c v/|v| + b_h (v_T - v) + k_h (x_T - x).
/// Rotation has the same form with the rotation vector from handle to target and a scalar inertia.
/// The hand: 0.55 kg, 6.5 N s/m, 135 N/m are usual values of a grip on a haptic handle.
///
/// Integration, in steps of h: the linear part exactly, for the target of mid-step (error of order h^2); Coulomb
/// friction as an impulse of c h/2 before and after it that at most brings the body to rest (Strang splitting); a body
/// at rest stays while the force on it is at most c. Stable for any constants.
class Handle {
 public:
  /// `sub_step` is the longest h in s.
  Handle(const HandleParameters& translation, const HandleParameters& rotation, double sub_step, bool rotate);

  void place(const MotionState& state) { state_ = state; }
  /// Moves on by `dt` s under the wrench on the handle, while the target moves from `from` to `to`.
  void advance(double dt, const Wrench& wrench, const MotionState& from, const MotionState& to);
  [[nodiscard]] const MotionState& state() const { return state_; }

 private:
  /// The exact step of M a = f - B v - K x from x = 0: x' = x_v v + x_f f, v' = v_v v + v_f f.
  struct Propagator {
    double x_v = 0, x_f = 0, v_v = 0, v_f = 0;
  };
  static Propagator make_propagator(const HandleParameters& coupling, double h);
  /// One step; `v` is the velocity before and after, the result the way moved.
  static Vec3 move(const HandleParameters& coupling, const Propagator& by, double h, const Vec3& f, Vec3& v);

  HandleParameters translation_;
  HandleParameters rotation_;
  double sub_step_;
  bool rotate_;
  double h_ = 0;  // the step the propagators are made for
  Propagator translate_by_;
  Propagator rotate_by_;
  MotionState state_;
};

}  // namespace tactor
