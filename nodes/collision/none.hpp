// collision.none: no contacts.
#pragma once

#include "nodes/collision/collision_node.hpp"

namespace tactor {

/// Sends an empty set, with the poses of the moving bodies, whenever another collision node would send its contacts:
/// the pipeline keeps its timing and nothing touches.
class NoCollision final : public CollisionNode {
 public:
  struct Params {
    double margin = 0;  ///< m
  };
  NoCollision(const Params& params, const NodeContext& context);
  static NodeInfo declare();

  using CollisionNode::query;
  void query(const BodyStates& bodies, ContactSet& set) override;
};

}  // namespace tactor
