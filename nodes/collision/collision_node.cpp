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

void require_moving_body(const Scene& scene) {
  if (scene.moving().empty()) throw InputError("collision needs a moving body in the scene");
}

CollisionNode::CollisionNode(const Scene& scene) : names_(names_of_moving(scene)) {
  for (const std::size_t i : scene.moving()) {
    const Body& body = scene.bodies[i];
    TACTOR_DEMAND(start_.count < BodyStates::capacity);
    start_.X_WB[static_cast<std::size_t>(start_.count++)] = body.X_WB;
  }
  require_moving_body(scene);
  at_ = start_;
}

void CollisionNode::query(const Pose& X_WT, ContactSet& set) {
  BodyStates at = start_;
  at.X_WB[0] = X_WT;
  query(at, set);
}

void CollisionNode::query_ahead(const BodyStates& at, double /*age*/, LocalContacts& around) {
  around.anchors = 1;
  around.bodies = at.count;
  around.count = 0;
  around.X_WB[0] = at.X_WB;
}

void CollisionNode::take_poses(Time now) {
  age_ = 0;
  const auto take = [&](const Stamped<BodyStates>& message, const char* input) {
    if (message.value.count != start_.count) {
      throw InputError(std::string("the input ") + input + " has " + std::to_string(message.value.count) +
                       " moving bodies; the scene has " + std::to_string(start_.count) + ": " + names_);
    }
    at_ = message.value;
    age_ = (now - message.stamp.valid).seconds();
  };
  const Stamped<BodyStates>* by_now = expected.connected() ? expected.latest() : nullptr;
  if (by_now != nullptr) return take(*by_now, "expected");
  if (bodies.connected()) {
    const Stamped<BodyStates>* last = bodies.latest();
    if (last != nullptr) take(*last, "bodies");
    return;
  }
  // A plan has seen to it.
  TACTOR_DEMAND(start_.count == 1);
  const Stamped<PhysicsState>* last = state.connected() ? state.latest() : nullptr;
  if (last == nullptr) return;
  at_.X_WB[0] = last->value.X_WT;
  at_.V_WB[0] = last->value.V_WT;
  age_ = (now - last->stamp.valid).seconds();
}

void CollisionNode::step(StepContext& context) {
  take_poses(context.now());
  query(at_, set_);
  context.add_work(set_.penetrating);
  ++queries_;
  if (set_.penetrating > 0) ++touching_queries_;
  contacts.send(context.now(), set_);
  if (!local.wanted()) return;
  query_ahead(at_, age_, local_);
  local.send(context.now(), local_);
}

}  // namespace tactor
