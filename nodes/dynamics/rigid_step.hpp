// One implicit step of a rigid tool that hangs on the coupling and touches contact planes.
#pragma once

#include <span>

#include <Eigen/Core>

#include "framework/core/messages.hpp"

namespace tactor {

/// The tool: pose, and velocity of its origin, in W.
struct ToolState {
  Pose X_WT;   ///< m
  Twist V_WT;  ///< m/s, rad/s
};

/// What stays the same from step to step.
struct ToolModel {
  double mass = 0;               ///< kg
  Eigen::Matrix3d inertia_T;     ///< kg m^2 about the tool origin, in T
  Vec3 gravity_W;                ///< m/s^2
  bool rotates = true;           ///< false: 3 degrees of freedom, the orientation stays
  int iterations = 4;            ///< Newton iterations a step, at most
  double stick_velocity = 5e-4;  ///< m/s, below which friction is viscous
};

/// The contact planes of one query.
struct ContactPlanes {
  Pose X_WT;  ///< the tool pose of the query
  std::span<const Contact> planes;
};

/// What a step found besides the new state.
struct StepResult {
  bool solved = false;  ///< false: the state is the old pose at rest
  bool converged =
      false;           ///< false: solved, but the last Newton iteration still changed the velocity by over 1e-4 of it
  Wrench contact_T_W;  ///< N, N m: sum of the contacts on the tool about its origin, at the new state
  int touching = 0;    ///< contacts with a force
};

/// Advances the tool by h seconds by implicit Euler, solved by Newton's method with a symmetric-friction Jacobian:
///   m (v' - v) / h                = m g + k_t (p_WD - p') + b_t (v_WD - v') + sum f_i,        p' = p + h v'
///   (I_W(R') w' - I_W(R) w) / h   = k_r log(R_WD R'^T) + b_r (w_WD - w') + sum r_i x f_i,     R' = exp(h w') R
/// with the handle (p_WD, R_WD, v_WD, w_WD) at the end of the step and without limits on its force. The rotation is in
/// angular momentum, so that a free body keeps its momentum exactly at any step. A contact at tool point r, velocity u:
///   phi = distance + n . (p_W(point now) - p_W(point at the query)),   N = max(0, -k phi - b n . u),
///   f = N n - min(mu N / |u_t|, mu N / stick_velocity) u_t,
/// with k = stiffness * weight, b = damping * weight. The damper meets a point that approaches at speed u from b u / k
/// above the surface on, so that the force has no step at the surface. With law.massless the left sides and gravity are
/// zero, and the tool is in balance. Throws nothing; a system that cannot be solved leaves the pose and sets the
/// velocity to zero. Implicit integration of contact and coupling: D. Baraff and A. Witkin, "Large steps in cloth
/// simulation", 1998.
StepResult rigid_step(const ToolModel& model, const CouplingLaw& law, const DeviceState& device,
                      const ContactPlanes& contacts, double h, ToolState& tool);

}  // namespace tactor
