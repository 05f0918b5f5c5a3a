// The force of the spring and damper between handle and tool.
#pragma once

#include "framework/core/messages.hpp"

namespace tactor {

/// True where a step can be made with that spring and damper: none is negative, NaN or so large that forces overflow.
[[nodiscard]] bool is_usable(const CouplingParameters& coupling);

/// The wrench on the device about its handle, in W (X. Hou and O. Sourina, "Real-time Adaptive Prediction Method for
/// Smooth Haptic Rendering", eq. 15 and 18, with the dissipative sign of the damper):
///   F = -k_t (p_WD - p_WT) - b_t (v_WD - v_WT),   tau = -k_r log(R_WD R_WT^T) - b_r (w_WD - w_WT),
/// each shortened to force_max and torque_max by its norm. The tool gets the opposite before the shortening: limiting
/// is the device's need, and a tool that felt the limited force would drift off. log is the rotation vector of the
/// shorter way round; q and -q give the same torque. With `torque` false the torque is zero.
Wrench coupling_wrench(const CouplingParameters& coupling, const PhysicsState& state, bool torque);

}  // namespace tactor
