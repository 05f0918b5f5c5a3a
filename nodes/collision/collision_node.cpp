#include "nodes/collision/collision_node.hpp"

#include <algorithm>

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
  query(at, 0, set);
}

/// Takes the last poses and velocities; returns the time that they are of, if they came.
std::optional<Time> CollisionNode::take_poses() {
  if (bodies.connected()) {
    const Stamped<BodyStates>* last = bodies.latest();
    if (last == nullptr) return {};
    if (last->value.count != start_.count) {
      throw InputError("the input bodies tells of " + std::to_string(last->value.count) +
                       " moving bodies; the scene has " + std::to_string(start_.count) + ": " + names_);
    }
    at_ = last->value;
    return last->stamp.valid;
  }
  // A plan has seen to it.
  TACTOR_DEMAND(start_.count == 1);
  const Stamped<PhysicsState>* last = state.connected() ? state.latest() : nullptr;
  if (last == nullptr) return {};
  at_.X_WB[0] = last->value.X_WT;
  at_.V_WB[0] = last->value.V_WT;
  return last->stamp.valid;
}

void CollisionNode::step(StepContext& context) {
  const Time now = context.now();
  const std::optional<Time> valid = take_poses();
  double period = 0;
  if (valid) period = std::max(period, (now - *valid).seconds());
  if (last_query_) period = std::max(period, (now - *last_query_).seconds());
  last_query_ = now;
  query(at_, std::min(period, longest_period), set_);
  context.add_work(set_.penetrating);
  contacts.send(now, set_);
}

}  // namespace tactor
