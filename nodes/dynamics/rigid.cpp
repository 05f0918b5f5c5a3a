#include "nodes/dynamics/rigid.hpp"

#include "nodes/dynamics/declare_dynamics.hpp"

namespace tactor {

RigidDynamics::RigidDynamics(const Params& params, const NodeContext& context)
    : DynamicsNode("dynamics.rigid", params, false, context) {}

NodeInfo RigidDynamics::declare() {
  Declare<RigidDynamics> d("dynamics.rigid",
                           "Rigid bodies, the tool among them on the coupling spring, with contacts.");
  d.details(
      "The node uses implicit Euler for the coupling and for the contacts' stiffness, damping and friction. It "
      "sub-steps through every device sample since the last step. Each sub-step is the minimum of a convex function, "
      "found by Newton's method. If the iterations do not suffice, a damped step is taken and counted. "
      "docs/results/stability_results.md maps where the method stays stable and where not. It adds numerical damping: "
      "a contact without damping gives back about exp(-pi w substep / 2) of the impact speed, with w = sqrt(k/m). "
      "`integrator: midpoint` adds none (docs/explanation/energy.md). With either integrator, free "
      "rotation keeps its energy. Up to 8 bodies are solved together; those with `motion: translation` do not rotate. "
      "The tool feels the true spring; the device gets the spring force limited to force_max.");
  declare_inertial(d);
  d.cheaper("dynamics.translation").cheaper("dynamics.quasistatic");
  return d.info();
}

}  // namespace tactor
