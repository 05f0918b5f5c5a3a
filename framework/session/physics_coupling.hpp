// The coupling between handle and tool in the forms that engines of physics take it in.
#pragma once

#include "framework/core/messages.hpp"

namespace tactor {

/// A spring and damper between the handle and the tool.
struct ImplicitSpring {
  double k_t = 0;  ///< N/m
  double b_t = 0;  ///< N s/m
  double k_r = 0;  ///< N m/rad
  double b_r = 0;  ///< N m s/rad
};

/// The coupling for an engine that takes a spring implicitly. With h = 0, stiffness and damping as they are: for an
/// engine that evaluates both at the end of its step. With h > 0 in s, the damping is b + h k: for an engine with steps
/// of h that takes only the damping implicitly. With the handle where it is at the beginning of the step,
///   F = k (x_D - x) + (b + h k) (v_D - v'),   v' the tool's velocity at the end,
/// is then implicit Euler. Throws InputError where h is below zero or not finite.
ImplicitSpring implicit_spring(const CouplingParameters& coupling, double h = 0);

/// The same as a constraint J v = -(erp / h) e - cfm lambda with a force lambda (Open Dynamics Engine, manual, 3.8.2):
///   erp = h k / (h k + b),   cfm = 1 / (h k + b).
/// It is implicit Euler of the spring. An engine whose lambda is an impulse takes cfm / h. Without spring and damper,
/// erp is zero and cfm infinite.
struct ErpCfm {
  double erp_t = 0;
  double cfm_t = 0;  ///< m/(N s)
  double erp_r = 0;
  double cfm_r = 0;  ///< rad/(N m s)
};
/// Throws InputError unless h, the step in s, is above zero and finite.
ErpCfm erp_cfm(const CouplingParameters& coupling, double h);

/// The tool as an explicit force moves it.
struct ExplicitTool {
  Pose X_WT;           ///< m
  Twist V_WT;          ///< m/s, rad/s
  double mass = 0;     ///< kg
  double inertia = 0;  ///< kg m^2, the smallest principal one; 0: the tool does not turn, and the torque is zero
};

/// The wrench of the coupling on the tool about its origin, in W, for an engine that takes forces and has steps of h:
///   F = k_t (p_WD - p_WT) + b_t (v_WD - v_WT),   torque likewise with the rotation vector of R_WD R_WT^T.
/// No limit of the device shortens it. A force that is held over a step is stable only where
///   h^2 k / m + 2 h b / m < 4;
/// that is the bound of v' = v + h F / m, x' = x + h v'. Throws InputError where it is not met, with the longest step
/// that meets it, and where mass, inertia or h are not usable.
Wrench explicit_wrench(const CouplingParameters& coupling, const DeviceState& handle, const ExplicitTool& tool,
                       double h);

/// The wrench of the coupling on the device about its handle, in W, as a graph's coupling shows it: the opposite of the
/// one on the tool, force and torque each shortened to the limits of the device. `turns`: false where the tool keeps
/// its rotation, and the torque is zero.
Wrench wrench_on_device(const CouplingParameters& coupling, const DeviceState& handle, const Pose& X_WT,
                        const Twist& V_WT, bool turns);

}  // namespace tactor
