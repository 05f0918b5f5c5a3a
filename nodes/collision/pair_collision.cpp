#include "nodes/collision/pair_collision.hpp"

#include <algorithm>
#include <numeric>

namespace tactor {

PairCollision::PairCollision(const PairParams& params, const NodeContext& context,
                             const MakeMeshDistance& make_distance)
    : CollisionNode(*context.scene) {
  const Scene& scene = *context.scene;
  const std::vector<std::size_t> moving = scene.moving();
  bodies_.reserve(scene.bodies.size());  // pairs refer to them
  for (const std::size_t i : moving) bodies_.emplace_back(scene.bodies[i], params.spacing, make_distance);
  for (const Body& body : scene.bodies) {
    if (body.motion == Motion::fixed) bodies_.emplace_back(body, params.spacing, make_distance);
  }
  std::size_t most = 0;
  for (std::size_t a = 0; a < moving.size(); ++a) {
    for (std::size_t b = a + 1; b < bodies_.size(); ++b) {
      const ContactPair indices{static_cast<std::int32_t>(a),
                                b < moving.size() ? static_cast<std::int32_t>(b) : ContactPair::fixed};
      pairs_.push_back({a, b, BodyPair(bodies_[a], bodies_[b], indices, params.margin)});
      most += pairs_.back().pair.most_contacts();
    }
  }
  most = std::min<std::size_t>(most, 4096);
  found_.reserve(most);
  of_pair_.reserve(most);
  order_.reserve(most);
}

const Pose& PairCollision::pose(const BodyStates& states, std::int32_t index, std::size_t body) const {
  return index == ContactPair::fixed ? bodies_[body].X_WB : states.X_WB[static_cast<std::size_t>(index)];
}

void PairCollision::query(const BodyStates& states, ContactSet& set) {
  found_.clear();
  of_pair_.clear();
  for (Entry& entry : pairs_) {
    const ContactPair indices = entry.pair.indices();
    entry.pair.find(pose(states, indices.body, entry.a), pose(states, indices.other, entry.b), found_);
    of_pair_.resize(found_.size(), indices);
  }

  set.bodies.count = states.count;
  std::copy_n(states.X_WB.begin(), states.count, set.bodies.X_WB.begin());
  order_.resize(found_.size());
  std::iota(order_.begin(), order_.end(), std::size_t{0});
  set.truncated = 0;
  if (order_.size() > ContactSet::capacity) {
    set.truncated = static_cast<std::int32_t>(order_.size()) - ContactSet::capacity;
    std::nth_element(order_.begin(), order_.begin() + ContactSet::capacity, order_.end(),
                     [&](std::size_t a, std::size_t b) {
                       const double da = found_[a].distance, db = found_[b].distance;
                       return da != db ? da < db : a < b;
                     });
    order_.resize(ContactSet::capacity);
    std::sort(order_.begin(), order_.end());
  }
  set.count = static_cast<std::int32_t>(order_.size());
  set.penetrating = 0;
  const auto pressure = [](const Contact& c) { return c.weight * std::max(0.0, -c.distance); };
  double kept = 0, all = 0;
  for (const Contact& c : found_) all += pressure(c);
  for (std::size_t i = 0; i < order_.size(); ++i) {
    set.contact[i] = found_[order_[i]];
    set.pair[i] = of_pair_[order_[i]];
    kept += pressure(set.contact[i]);
    if (set.contact[i].distance < 0) ++set.penetrating;
  }
  if (set.truncated > 0 && kept > 0) {
    for (std::size_t i = 0; i < order_.size(); ++i) set.contact[i].weight *= all / kept;
  }
}

}  // namespace tactor
