// A scene of MuJoCo whose tool hangs on the coupling.
#pragma once

#include <memory>

#include "nodes/physics/engine/coupled_engine.hpp"

namespace tactor {

/// The coupling as rows of MuJoCo's constraint solver, solved with the contacts. Of a degree of freedom with the gap
/// g to the handle, the tool's speed u and acceleration a, and the handle's speed u_D at the end of the step,
///   force = k (g - h u - h^2 a) + b (u_D - u - h a) = (aref - a) / R,
///   1 / R = h b + h^2 k,   aref = R [k g + b u_D - (b + h k) u],
/// which is implicit Euler. The rows are those of the weld that read_coupled_model adds: they are overwritten between
/// MuJoCo's two halves of a step. A fatal error, a warning of MuJoCo (it resets a scene that has become unstable) or a
/// tool that is not finite fails the step.
///
/// Throws ValueError as read_coupled_model does, and about `keyframe` or `bodies` where the model has none of that
/// name.
std::unique_ptr<CoupledEngine> make_mujoco_engine(const EngineModel& model);

}  // namespace tactor
