// Bodies with a patch of deforming surfaces.
#include "nodes/physics/mechanics/rigid_step_solve.hpp"

namespace tactor {

template StepResult RigidStep::solve<Eigen::Dynamic, Integrator::implicit_euler, RigidStep::most_patch_nodes>(
    const CouplingParameters& coupling, const DeviceState& device, const ContactPlanes& contacts, double h,
    BodyStates& bodies, const SoftPatch* patch, SoftPatchMotion* motion);
template StepResult RigidStep::solve<Eigen::Dynamic, Integrator::midpoint, RigidStep::most_patch_nodes>(
    const CouplingParameters& coupling, const DeviceState& device, const ContactPlanes& contacts, double h,
    BodyStates& bodies, const SoftPatch* patch, SoftPatchMotion* motion);

}  // namespace tactor
