// Several bodies.
#include "nodes/physics/mechanics/rigid_step_solve.hpp"

namespace tactor {

template StepResult RigidStep::solve<Eigen::Dynamic>(Integrator integrator, const CouplingParameters& coupling,
                                                     const DeviceState& device, const ContactPlanes& contacts, double h,
                                                     BodyStates& bodies);

}  // namespace tactor
