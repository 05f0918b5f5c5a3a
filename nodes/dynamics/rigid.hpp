// dynamics.rigid: bodies with 6 degrees of freedom between the handle's spring and the contacts.
#pragma once

#include "framework/node/info.hpp"
#include "nodes/dynamics/dynamics_node.hpp"

namespace tactor {

/// All moving bodies of the scene as rigid bodies, those of Motion::translation without rotation. Throws RunError at
/// the first coupling of a massless tool.
class RigidDynamics final : public DynamicsNode {
 public:
  using Params = InertialParams;
  RigidDynamics(const Params& params, const NodeContext& context);
  static NodeInfo declare();
};

}  // namespace tactor
