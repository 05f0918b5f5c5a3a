#include "nodes/collision/pair_collision.hpp"

#include <algorithm>

#include "framework/core/check.hpp"

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
    : CollisionNode(*context.scene), reduction_(params.max_contacts, usual_contacts), local_reduction_(params.local_contacts, usual_contacts) {
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

void PairCollision::query_ahead(std::span<const BodyStates> anchors, LocalContacts& around) {
  TACTOR_ASSERT(!anchors.empty() && anchors.size() <= ahead_.size());
  const auto pose_at = [this, &anchors](std::size_t anchor, std::int32_t index, std::size_t body) -> const Pose& {
    return pose(anchors[anchor], index, body);
  };
  keys_.clear();
  for (std::size_t j = 0; j < anchors.size(); ++j) {
    Ahead& ahead = ahead_[j];
    ahead.found.clear();
    ahead.shares.clear();
    for (Entry& entry : pairs_) {
      const ContactPair indices = entry.pair.indices();
      entry.pair.find(pose_at(j, indices.body, entry.a), pose_at(j, indices.other, entry.b), ahead.found);
      ahead.shares.push_back(entry.pair.shares());
    }
    keys_.insert(keys_.end(), ahead.found.key.begin(), ahead.found.key.end());
  }
  std::sort(keys_.begin(), keys_.end());
  keys_.erase(std::unique(keys_.begin(), keys_.end()), keys_.end());
  // Where a pair has no contact at an anchor, its shares are those of another.
  for (std::size_t e = 0; e < pairs_.size(); ++e) {
    BodyPair::Shares known;
    for (std::size_t j = 0; j < anchors.size(); ++j) {
      const BodyPair::Shares& s = ahead_[j].shares[e];
      if (s.a + s.b > 0) known = s;
    }
    for (std::size_t j = 0; j < anchors.size(); ++j) {
      BodyPair::Shares& s = ahead_[j].shares[e];
      if (s.a + s.b == 0) s = known;
    }
  }
  const auto contact_at = [&](std::size_t j, std::uint64_t key) {
    const auto e = static_cast<std::size_t>(pair_number(key));
    const Entry& entry = pairs_[e];
    const ContactPair indices = entry.pair.indices();
    return entry.pair.at(key, pose_at(j, indices.body, entry.a), pose_at(j, indices.other, entry.b),
                         ahead_[j].shares[e]);
  };
  const std::size_t middle = anchors.size() / 2;
  around_.clear();
  for (const std::uint64_t key : keys_) {
    around_.contact.push_back(contact_at(middle, key));
    around_.pair.push_back(pairs_[static_cast<std::size_t>(pair_number(key))].pair.indices());
    around_.key.push_back(key);
  }
  local_reduction_.reduce(around_, local_set_);

  around.anchors = static_cast<std::int32_t>(anchors.size());
  around.bodies = anchors[0].count;
  around.count = local_set_.count;
  for (std::size_t j = 0; j < anchors.size(); ++j) around.X_WB[j] = anchors[j].X_WB;
  for (std::size_t i = 0; i < static_cast<std::size_t>(around.count); ++i) {
    const std::size_t from = local_reduction_.kept()[i];
    const double before = around_.contact[from].weight;
    const double change = before > 0 ? local_set_.contact[i].weight / before : 1;
    around.pair[i] = around_.pair[from];
    for (std::size_t j = 0; j < anchors.size(); ++j) {
      Contact& c = around.contact[i][j];
      c = j == middle ? around_.contact[from] : contact_at(j, around_.key[from]);
      c.weight *= change;
    }
  }
}

}  // namespace tactor
