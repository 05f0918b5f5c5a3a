#include "nodes/dynamics/rigid.hpp"

#include "nodes/dynamics/declare_dynamics.hpp"

namespace tactor {

RigidDynamics::RigidDynamics(const Params& params, const NodeContext& context)
    : DynamicsNode("dynamics.rigid", params, false, context) {}

NodeInfo RigidDynamics::declare() {
  Declare<RigidDynamics> d("dynamics.rigid",
                           "Rigid bodies, the tool among them on the coupling spring, with contacts.");
  d.details(
      "Implicit Euler in the coupling and the contacts' stiffness, damping and friction, sub-stepped through every "
      "device sample since the last step. Each sub-step is the minimum of a convex function, which Newton's method "
      "finds within the iterations or else a damped step stands in for, and is counted. Where it "
      "stays stable, and where not, is mapped in docs/results/stability_results.md. It adds numerical damping: a "
      "contact that "
      "has "
      "none gives back about exp(-pi w substep / 2) of the speed that it is met with, w = sqrt(k/m). `integrator: "
      "midpoint` adds none (docs/explanation/energy.md). Free rotation keeps its energy by either. "
      "Up to 8 bodies are solved as one, those of `motion: translation` without rotation. The tool feels the true "
      "spring, the device the one limited to force_max.");
  declare_inertial(d);
  d.cheaper("dynamics.translation").cheaper("dynamics.quasistatic");
  return d.info();
}

}  // namespace tactor
