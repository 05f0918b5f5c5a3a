#include "nodes/collision/collision_node.hpp"

#include "framework/core/check.hpp"

namespace tactor {

namespace {
/// `tool, block`
std::string names_of_moving(const Scene& scene) {
  std::string names;
  for (const std::size_t i : scene.moving()) names += (names.empty() ? "" : ", ") + scene.bodies[i].name;
  return names;
}
}  // namespace

std::string several_move(const Scene& scene) {
  const std::size_t moving = scene.moving().size();
  return moving < 2 ? std::string() : std::to_string(moving) + " bodies move: " + names_of_moving(scene);
}

CollisionNode::CollisionNode(const Scene& scene) : names_(names_of_moving(scene)) {
  for (const std::size_t i : scene.moving()) {
    const Body& body = scene.bodies[i];
    TACTOR_DEMAND(start_.count < BodyStates::capacity);
    start_.X_WB[static_cast<std::size_t>(start_.count++)] = body.X_WB;
  }
  if (start_.count == 0) throw InputError("collision needs a moving body in the scene");
  at_ = start_;
}

void CollisionNode::query(const Pose& X_WT, ContactSet& set) {
  BodyStates at = start_;
  at.X_WB[0] = X_WT;
  query(at, set);
}

void CollisionNode::take_poses() {
  if (bodies.connected()) {
    const Stamped<BodyStates>* last = bodies.latest();
    if (last == nullptr) return;
    if (last->value.count != start_.count) {
      throw InputError("the input bodies tells of " + std::to_string(last->value.count) +
                       " moving bodies; the scene has " + std::to_string(start_.count) + ": " + names_);
    }
    at_ = last->value;
    return;
  }
  // A plan has seen to it.
  TACTOR_DEMAND(start_.count == 1);
  const Stamped<PhysicsState>* last = state.connected() ? state.latest() : nullptr;
  if (last != nullptr) at_.X_WB[0] = last->value.X_WT;
}

void CollisionNode::step(StepContext& context) {
  take_poses();
  query(at_, set_);
  context.add_work(set_.penetrating);
  contacts.send(context.now(), set_);
}

}  // namespace tactor
