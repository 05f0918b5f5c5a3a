// dynamics.translation: bodies that move without rotating.
#pragma once

#include "framework/node/info.hpp"
#include "nodes/dynamics/dynamics_node.hpp"

namespace tactor {

/// All moving bodies with 3 degrees of freedom each; no rotation is computed. Throws InputError where a body may rotate
/// and RunError at the first coupling of a massless tool.
class TranslationDynamics final : public DynamicsNode {
 public:
  using Params = InertialParams;
  TranslationDynamics(const Params& params, const NodeContext& context);
  static NodeInfo declare();
};

}  // namespace tactor
