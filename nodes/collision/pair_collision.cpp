#include "nodes/collision/pair_collision.hpp"

#include <algorithm>

namespace tactor {

namespace {

// Of larger contacts the first few queries allocate.
constexpr std::size_t usual_contacts = 4096;

/// How far from the body's surface other bodies are sampled when they are within the margin: the largest ball that may
/// meet it has its centre there.
double reach_to(const Body& body, const Scene& scene, double margin) {
  double largest = 0;
  for (const Body& other : scene.bodies) {
    if (&other == &body || (body.motion == Motion::fixed && other.motion == Motion::fixed)) continue;
    if (const auto* sphere = std::get_if<SphereShape>(&other.shape)) largest = std::max(largest, sphere->radius);
    if (const auto* capsule = std::get_if<CapsuleShape>(&other.shape)) largest = std::max(largest, capsule->radius);
  }
  return largest + margin;
}

}  // namespace

PairCollision::PairCollision(const PairParams& params, const NodeContext& context,
                             const MakeMeshDistance& make_distance)
    : CollisionNode(*context.scene), reduction_(params.max_contacts, usual_contacts) {
  const Scene& scene = *context.scene;
  const std::vector<std::size_t> moving = scene.moving();
  bodies_.reserve(scene.bodies.size());  // pairs refer to them
  const auto add = [&](const Body& body) {
    bodies_.emplace_back(body, params.spacing, reach_to(body, scene, params.margin), make_distance, context.notes);
  };
  for (const std::size_t i : moving) add(scene.bodies[i]);
  for (const Body& body : scene.bodies) {
    if (body.motion == Motion::fixed) add(body);
  }
  for (std::size_t a = 0; a < moving.size(); ++a) {
    for (std::size_t b = a + 1; b < bodies_.size(); ++b) {
      const ContactPair indices{static_cast<std::int32_t>(a),
                                b < moving.size() ? static_cast<std::int32_t>(b) : ContactPair::fixed};
      const auto number = static_cast<std::uint32_t>(pairs_.size());
      pairs_.push_back({a, b, BodyPair(bodies_[a], bodies_[b], indices, number, params.margin)});
    }
  }
  found_.reserve(usual_contacts);
}

const Pose& PairCollision::pose(const BodyStates& states, std::int32_t index, std::size_t body) const {
  return index == ContactPair::fixed ? bodies_[body].X_WB : states.X_WB[static_cast<std::size_t>(index)];
}

void PairCollision::query(const BodyStates& states, ContactSet& set) {
  found_.clear();
  for (Entry& entry : pairs_) {
    const ContactPair indices = entry.pair.indices();
    entry.pair.find(pose(states, indices.body, entry.a), pose(states, indices.other, entry.b), found_);
  }
  set.bodies.count = states.count;
  std::copy_n(states.X_WB.begin(), states.count, set.bodies.X_WB.begin());
  reduction_.reduce(found_, set);
}

}  // namespace tactor
