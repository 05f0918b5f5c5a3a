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

constexpr double most_turn = 0.5;  // rad, that is foreseen

}  // namespace

Course course_of(const Pose& X, const Twist& V, double ahead) {
  if (ahead <= 0 || !is_finite(V.v) || !is_finite(V.w)) return {X, X};
  Vec3 turn = ahead * V.w;
  const double angle = norm(turn);
  if (angle > most_turn) turn *= most_turn / angle;
  return {X, {X.p + ahead * V.v, turn == Vec3{} ? X.R : from_rotation_vector(turn) * X.R}};
}

PairCollision::PairCollision(const PairParams& params, const NodeContext& context,
                             const MakeMeshDistance& make_distance)
    : CollisionNode(*context.scene), look_ahead_(params.look_ahead), reduction_(params.max_contacts, usual_contacts) {
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

Course PairCollision::course(const BodyStates& states, std::size_t body, double ahead) const {
  if (bodies_[body].motion == Motion::fixed) return {bodies_[body].X_WB, bodies_[body].X_WB};
  return course_of(states.X_WB[body], states.V_WB[body], ahead);
}

void PairCollision::query(const BodyStates& states, double period, ContactSet& set) {
  found_.clear();
  const double ahead = look_ahead_ * period;
  for (Entry& entry : pairs_) entry.pair.find(course(states, entry.a, ahead), course(states, entry.b, ahead), found_);
  set.bodies.count = states.count;
  std::copy_n(states.X_WB.begin(), states.count, set.bodies.X_WB.begin());
  reduction_.reduce(found_, set);
}

}  // namespace tactor
