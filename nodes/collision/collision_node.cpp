#include "nodes/collision/collision_node.hpp"

namespace tactor {

void CollisionNode::step(StepContext& context) {
  const Stamped<PhysicsState>* last = state.connected() ? state.latest() : nullptr;
  query(last != nullptr ? last->value.X_WT : X_WT_start_, set_);
  context.add_work(set_.penetrating);
  contacts.send(context.now(), set_);
}

}  // namespace tactor
