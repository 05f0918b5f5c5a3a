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

void CollisionNode::query_ahead(std::span<const BodyStates> anchors, LocalContacts& around) {
  around.anchors = static_cast<std::int32_t>(anchors.size());
  around.count = 0;
}

void CollisionNode::take_poses(Time now) {
  age_ = 0;
  const auto take = [&](const Stamped<BodyStates>& message, const char* input) {
    if (message.value.count != start_.count) {
      throw InputError(std::string("the input ") + input + " tells of " + std::to_string(message.value.count) +
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

namespace {
/// Where the bodies are `time` s later if they keep their velocities.
BodyStates moved_on(const BodyStates& bodies, double time) {
  BodyStates later = bodies;
  for (std::size_t i = 0; i < static_cast<std::size_t>(bodies.count); ++i) {
    later.X_WB[i].p += time * bodies.V_WB[i].v;
    later.X_WB[i].R = from_rotation_vector(time * bodies.V_WB[i].w) * later.X_WB[i].R;
  }
  return later;
}
}  // namespace

void CollisionNode::step(StepContext& context) {
  take_poses(context.now());
  period_.update(context.now());
  query(at_, set_);
  context.add_work(set_.penetrating);
  contacts.send(context.now(), set_);
  if (!local.wanted()) return;
  const double T = period_.value().seconds();
  const std::array<BodyStates, 3> anchors{moved_on(at_, age_), moved_on(at_, age_ + T), moved_on(at_, age_ + 2 * T)};
  query_ahead(anchors, local_);
  local.send(context.now(), local_);
}

}  // namespace tactor
