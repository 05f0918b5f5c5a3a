// The damping of a spring, and the node that every kind of coupling shares.
#pragma once

#include <optional>

#include "framework/core/messages.hpp"
#include "framework/node/node.hpp"

namespace tactor {

/// The damping of a spring k on an inertia m with damping ratio zeta: 2 zeta sqrt(k m). SI units of either k (N/m
/// with kg, N m/rad with kg m^2).
double damping_of(double k, double m, double zeta);

/// What of the scene's tool a coupling depends on.
struct CoupledTool {
  double mass = 0;      ///< kg
  double inertia = 0;   ///< kg m^2, the mean principal one; 0 where nothing rotates
  bool torque = false;  ///< it rotates
};

/// The tool of the scene. Throws InputError where there is none, or where it rotates and its mesh has no volume; `type`
/// is that of the coupling.
CoupledTool coupled_tool(const char* type, const NodeContext& context);

/// What every coupling does: sends its parameters in start() and when they change, then a force for each state, stamped
/// as the state. Parameters that are set while it runs are reached in 0.1 s, in a straight line from step to step.
class CouplingNode : public Node {
 public:
  void start(StepContext& context) override;
  void step(StepContext& context) override;

  Input<PhysicsState> state;
  Output<Wrench> force;
  Output<CouplingParameters> parameters;

 protected:
  CouplingNode(const CouplingParameters& sent, bool torque) : parameters_(sent), torque_(torque) {}
  /// Goes to these parameters from the next step on.
  void go_to(const CouplingParameters& target);

 private:
  void go_on(Time now);

  CouplingParameters parameters_;
  bool torque_;
  CouplingParameters from_, target_;
  bool changing_ = false;
  std::optional<Time> changing_since_;
};

/// The parameters that every coupling has.
struct CouplingLimits {
  double force_max = 0;   ///< N
  double torque_max = 0;  ///< N m
};

}  // namespace tactor
