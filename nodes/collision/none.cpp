#include "nodes/collision/none.hpp"

#include <algorithm>

namespace tactor {

NoCollision::NoCollision(const Params& /*params*/, const NodeContext& context) : CollisionNode(*context.scene) {}

void NoCollision::query(const BodyStates& states, ContactSet& set) {
  set.bodies.count = states.count;
  std::copy_n(states.X_WB.begin(), states.count, set.bodies.X_WB.begin());
  set.count = set.penetrating = set.truncated = 0;
}

NodeInfo NoCollision::declare() {
  Declare<NoCollision> d("collision.none", "No contacts: the pipeline keeps its timing and nothing touches.");
  d.details(
      "Use it to see what a scene does without contact. Like every collision node, it is left out if there is nothing "
      "to hit.");
  declare_collision(d);
  return d.info();
}

}  // namespace tactor
