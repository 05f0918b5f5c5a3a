// One body that rotates.
#include "nodes/physics/mechanics/rigid_step_solve.hpp"

namespace tactor {

template StepResult RigidStep::solve<6, Integrator::implicit_euler>(const CouplingParameters& coupling,
                                                                    const DeviceState& device,
                                                                    const ContactPlanes& contacts, double h,
                                                                    BodyStates& bodies, const SoftPatch* patch,
                                                                    SoftPatchMotion* motion);
template StepResult RigidStep::solve<6, Integrator::midpoint>(const CouplingParameters& coupling,
                                                              const DeviceState& device, const ContactPlanes& contacts,
                                                              double h, BodyStates& bodies, const SoftPatch* patch,
                                                              SoftPatchMotion* motion);

}  // namespace tactor
