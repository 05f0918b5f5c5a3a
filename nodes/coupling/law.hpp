// The force of the spring and damper between handle and tool, and the node that every kind of coupling shares.
#pragma once

#include "framework/core/messages.hpp"
#include "framework/node/node.hpp"

namespace tactor {

/// The wrench on the device about its handle, in W (X. Hou and O. Sourina, "Real-time Adaptive Prediction Method for
/// Smooth Haptic Rendering", eq. 15 and 18, with the dissipative sign of the damper):
///   F = -k_t (p_WD - p_WT) - b_t (v_WD - v_WT),   tau = -k_r log(R_WD R_WT^T) - b_r (w_WD - w_WT),
/// each shortened to force_max and torque_max by its norm. The tool gets the opposite before the shortening: limiting
/// is the device's need, and a tool that felt the limited force would drift off. log is the rotation vector of the
/// shorter way round; q and -q give the same torque. With `torque` false the torque is zero.
Wrench coupling_wrench(const CouplingLaw& law, const PhysicsState& state, bool torque);

/// The damping of a spring k on an inertia m with damping ratio zeta: 2 zeta sqrt(k m). SI units of either k (N/m
/// with kg, N m/rad with kg m^2).
double damping_of(double k, double m, double zeta);

/// What every coupling does: sends its law once in start(), then a force for each state, stamped as the state.
class CouplingNode : public Node {
 public:
  void start(StepContext& context) override;
  void step(StepContext& context) override;

  Input<PhysicsState> state;
  Output<Wrench> force;
  Output<CouplingLaw> law;

 protected:
  CouplingNode(const CouplingLaw& law_of_node, bool torque) : law_(law_of_node), torque_(torque) {}

 private:
  CouplingLaw law_;
  bool torque_;
};

/// The parameters that every coupling has.
struct CouplingLimits {
  double force_max = 0;   ///< N
  double torque_max = 0;  ///< N m
};

}  // namespace tactor
