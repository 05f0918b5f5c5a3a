// The damping of a spring, and the node that every kind of coupling shares.
#pragma once

#include "framework/core/messages.hpp"
#include "framework/node/node.hpp"

namespace tactor {

/// The damping of a spring k on an inertia m with damping ratio zeta: 2 zeta sqrt(k m). SI units of either k (N/m
/// with kg, N m/rad with kg m^2).
double damping_of(double k, double m, double zeta);

/// What every coupling does: sends its parameters once in start(), then a force for each state, stamped as the state.
class CouplingNode : public Node {
 public:
  void start(StepContext& context) override;
  void step(StepContext& context) override;

  Input<PhysicsState> state;
  Output<Wrench> force;
  Output<CouplingParameters> parameters;

 protected:
  CouplingNode(const CouplingParameters& sent, bool torque) : parameters_(sent), torque_(torque) {}

 private:
  CouplingParameters parameters_;
  bool torque_;
};

/// The parameters that every coupling has.
struct CouplingLimits {
  double force_max = 0;   ///< N
  double torque_max = 0;  ///< N m
};

}  // namespace tactor
