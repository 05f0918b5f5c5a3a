// dynamics.quasistatic: a massless tool where the handle's spring and the contacts balance.
#pragma once

#include "framework/node/info.hpp"
#include "nodes/dynamics/dynamics_node.hpp"

namespace tactor {

/// The tool without mass, weight and dampers: each sub-step puts it where the coupling's spring, the contacts' springs
/// and friction (along the way of the sub-step) balance. Its velocity is that way over the sub-step. Throws InputError
/// where the scene has a second moving body.
class QuasistaticDynamics final : public DynamicsNode {
 public:
  using Params = DynamicsParams;
  QuasistaticDynamics(const Params& params, const NodeContext& context);
  static NodeInfo declare();
};

}  // namespace tactor
