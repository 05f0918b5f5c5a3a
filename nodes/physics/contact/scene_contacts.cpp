#include "nodes/physics/contact/scene_contacts.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "nodes/physics/contact/doubts.hpp"
#include "nodes/physics/contact/moved_on.hpp"

namespace tactor {

namespace {

// Of larger contacts the first few queries allocate, unless reserve_within was called.
constexpr std::size_t usual_contacts = 4096;

/// Two bodies of the scene that are looked at as a pair.
bool is_pair(const Body& a, const Body& b) {
  // Contacts of deformable bodies are those of SoftContacts.
  if (a.motion == Motion::deformable || b.motion == Motion::deformable) return false;
  return &a != &b && (a.moves() || b.moves());
}

/// How far from the body's surface other bodies are sampled when they are within the margin: the largest ball that may
/// meet it has its centre there.
double reach_to(const Body& body, const Scene& scene, double margin) {
  double largest = 0;
  for (const Body& other : scene.bodies) {
    if (!is_pair(body, other)) continue;
    if (const auto* sphere = std::get_if<SphereShape>(&other.shape)) largest = std::max(largest, sphere->radius);
    if (const auto* capsule = std::get_if<CapsuleShape>(&other.shape)) largest = std::max(largest, capsule->radius);
  }
  return largest + margin;
}

/// Whether a mesh of this body needs samples: those of spheres and capsules stand for both sides.
bool is_sampled(const Body& body, const Scene& scene) {
  return std::any_of(scene.bodies.begin(), scene.bodies.end(), [&body](const Body& other) {
    return is_pair(body, other) && !std::holds_alternative<SphereShape>(other.shape) &&
           !std::holds_alternative<CapsuleShape>(other.shape);
  });
}

/// Whether the distances between the body's contact samples are those of the spacing.
bool is_spaced(const Body& body, const Scene& scene) {
  if (body.mesh() != nullptr) return is_sampled(body, scene);
  if (!std::holds_alternative<BoxShape>(body.shape) && !std::holds_alternative<CapsuleShape>(body.shape)) return false;
  return std::any_of(scene.bodies.begin(), scene.bodies.end(),
                     [&body](const Body& other) { return is_pair(body, other); });
}

}  // namespace

bool has_spaced_samples(const Scene& scene) {
  return std::any_of(scene.bodies.begin(), scene.bodies.end(),
                     [&scene](const Body& body) { return is_spaced(body, scene); });
}

SceneContacts::SceneContacts(const Scene& scene, const ContactOptions& options, const MakeMeshDistance& make_distance,
                             const HandPath* hand, Notes* notes)
    : reduction_(options.max_contacts, usual_contacts),
      margin_(options.margin),
      anchor_count_(static_cast<std::size_t>(options.anchors)),
      anchor_time_(options.anchor_time),
      local_reduction_(options.local_contacts, usual_contacts) {
  const std::vector<std::size_t> moving = scene.moving();
  bodies_.reserve(scene.bodies.size());  // pairs refer to them
  const auto add = [&](const Body& body) {
    bodies_.emplace_back(body, options.spacing, is_sampled(body, scene), reach_to(body, scene, options.margin),
                         make_distance, notes);
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
      pairs_.push_back({a, b, BodyPair(bodies_[a], bodies_[b], indices, number, options.margin)});
    }
  }
  found_.reserve(usual_contacts);
  found_ahead_.reserve(usual_contacts);
  around_.reserve(usual_contacts);
  keys_.reserve(LocalContacts::max_anchors * usual_contacts);
  near_.reserve(LocalContacts::max_anchors * usual_contacts);
  ahead_.resize(pairs_.size());
  for (Anchor& anchor : anchors_) anchor.shares.reserve(pairs_.size());
  if (notes != nullptr) tell_doubts(scene, options.spacing, hand, *notes);
}

void SceneContacts::tell_doubts(const Scene& scene, double spacing, const HandPath* hand, Notes& notes) const {
  const auto tell = [&notes](const std::vector<std::string>& doubts) {
    notes.insert(notes.end(), doubts.begin(), doubts.end());
  };
  std::vector<bool> spaced;
  for (const ContactBody& body : bodies_) {
    const auto same = [&body](const Body& b) { return b.name == body.name; };
    spaced.push_back(is_spaced(*std::find_if(scene.bodies.begin(), scene.bodies.end(), same), scene));
  }
  tell(doubts_of_spacing(bodies_, spaced, spacing));
  if (hand != nullptr) tell(doubts_of_path(bodies_, *hand));
  for (const Entry& entry : pairs_) {
    // Where the tool starts, the hand alone tells.
    if (entry.a == 0 && hand == nullptr) continue;
    Pose X_WA = bodies_[entry.a].X_WB;
    if (entry.a == 0) X_WA = {hand->X_WH.front().p, scene.rotates() ? hand->X_WH.front().R : X_WA.R};
    BodyPair pair = entry.pair;  // a look of its own, which the run does not remember
    FoundContacts found;
    pair.find(X_WA, bodies_[entry.b].X_WB, found);
    double least = 0;
    for (const Contact& contact : found.contact) least = std::min(least, contact.distance);
    tell(doubts_of_start(bodies_[entry.a], bodies_[entry.b], -least));
  }
}

const Pose& SceneContacts::pose(const BodyStates& states, std::int32_t index, std::size_t body) const {
  return index == ContactPair::fixed ? bodies_[body].X_WB : states.X_WB[static_cast<std::size_t>(index)];
}

bool SceneContacts::look(const BodyStates& states, int* left) {
  found_.clear();
  for (Entry& entry : pairs_) {
    const ContactPair indices = entry.pair.indices();
    entry.pair.find(pose(states, indices.body, entry.a), pose(states, indices.other, entry.b), found_, left);
    if (left != nullptr && *left < 0) return false;
  }
  return true;
}

void SceneContacts::keep(const BodyStates& states, ContactSet& set) {
  set.bodies.count = states.count;
  std::copy_n(states.X_WB.begin(), states.count, set.bodies.X_WB.begin());
  reduction_.reduce(found_, set);
}

void SceneContacts::find(const BodyStates& states, ContactSet& set) {
  look(states, nullptr);
  keep(states, set);
}

bool SceneContacts::find_within(int work, const BodyStates& states, ContactSet& set, int* used) {
  int left = work;
  const bool enough = look(states, &left);
  if (used != nullptr) *used = enough ? work - left : work;
  if (enough) keep(states, set);
  return enough;
}

void SceneContacts::reserve_within(int work) {
  // A pair that has not moved costs no work, so each may add its most.
  std::size_t most = 0;
  for (Entry& entry : pairs_) most += entry.pair.reserve_within(work);
  found_.reserve(most);
  reduction_.reserve(most);
}

/// Adds the keys of the contacts at an anchor and notes what each side of a pair has there.
void SceneContacts::find_at(std::size_t j) {
  Anchor& anchor = anchors_[j];
  found_ahead_.clear();
  anchor.shares.clear();
  for (Entry& entry : pairs_) {
    const ContactPair indices = entry.pair.indices();
    entry.pair.find(pose(anchor.bodies, indices.body, entry.a), pose(anchor.bodies, indices.other, entry.b),
                    found_ahead_);
    anchor.shares.push_back(entry.pair.shares());
  }
  keys_.insert(keys_.end(), found_ahead_.key.begin(), found_ahead_.key.end());
  for (std::size_t i = 0; i < found_ahead_.key.size(); ++i) {
    const std::uint64_t key = found_ahead_.key[i];
    const auto e = static_cast<std::size_t>(pair_number(key));
    if (!pairs_[e].pair.has_two_sides()) continue;
    const Contact& c = found_ahead_.contact[i];
    const double within = margin_ - c.distance;
    near_.push_back({key, j, c.weight * within, c.weight * (std::max(0.0, -c.distance) + 1e-3 * within)});
  }
}

/// Where a pair has no contact at an anchor, its shares there are those of the last one that has.
void SceneContacts::fill_shares() {
  for (std::size_t e = 0; e < pairs_.size(); ++e) {
    BodyPair::Shares known;
    for (const Anchor& anchor : anchors()) {
      if (anchor.shares[e].a + anchor.shares[e].b > 0) known = anchor.shares[e];
    }
    for (Anchor& anchor : anchors()) {
      if (anchor.shares[e].a + anchor.shares[e].b == 0) anchor.shares[e] = known;
    }
  }
}

/// What the samples of each side do over the anchors.
void SceneContacts::look_at_sides() {
  std::fill(ahead_.begin(), ahead_.end(), std::array<SideAhead, 2>{});
  std::sort(near_.begin(), near_.end(), [](const NearSample& x, const NearSample& y) { return x.key < y.key; });
  for (std::size_t i = 0; i < near_.size();) {
    const std::uint64_t key = near_[i].key;
    SideAhead& side = ahead_[static_cast<std::size_t>(pair_number(key))][is_from_b(key) ? 1 : 0];
    double least = near_[i].extent, most = least;
    std::size_t anchors_near = 0;
    for (; i < near_.size() && near_[i].key == key; ++i, ++anchors_near) {
      least = std::min(least, near_[i].extent);
      most = std::max(most, near_[i].extent);
      side.push[near_[i].anchor] += near_[i].push;
    }
    if (anchors_near == anchor_count_) side.least += least;
    side.most += most;
  }
}

/// Changes the shares of pairs with samples on both sides as find_ahead says. A side that lasts less than the other, by
/// d, keeps ((1 - d)^10 - 0.05) / 0.95 of its share: nothing where d is above 0.26, and all where neither lasts.
void SceneContacts::prefer_lasting_sides() {
  look_at_sides();
  for (std::size_t e = 0; e < pairs_.size(); ++e) {
    const SideAhead &a = ahead_[e][0], &b = ahead_[e][1];
    // One side alone has samples there.
    if (a.most == 0 || b.most == 0) continue;
    const double best = std::max(a.lasting(), b.lasting());
    const auto kept = [best](const SideAhead& side) {
      return std::max(0.0, (std::pow(1 - (best - side.lasting()), 10) - 0.05) / 0.95);
    };
    const double kept_a = kept(a), kept_b = kept(b);
    for (std::size_t j = 0; j < anchor_count_; ++j) {
      // What is kept is made to push as both did. Where that takes more than a factor of four (it is about two where
      // the shares were alike), as where only the other side touches, so much of the other is kept too.
      const double both = a.push[j] + b.push[j], preferred = kept_a * a.push[j] + kept_b * b.push[j];
      if (!(both > 0)) continue;
      const double part = preferred < both / 4 ? 0.75 * both / (both - preferred) : 1;
      const double scale = both / (both + part * (preferred - both));
      BodyPair::Shares& shares = anchors_[j].shares[e];
      shares = {scale * (1 + part * (kept_a - 1)) * shares.a, scale * (1 + part * (kept_b - 1)) * shares.b};
    }
  }
}

/// Whether the contact has weight at an anchor.
bool SceneContacts::counts(std::uint64_t key) const {
  const auto e = static_cast<std::size_t>(pair_number(key));
  if (!pairs_[e].pair.has_two_sides()) return true;
  return std::any_of(
      anchors_.begin(), anchors_.begin() + static_cast<std::ptrdiff_t>(anchor_count_),
      [&](const Anchor& anchor) { return (is_from_b(key) ? anchor.shares[e].b : anchor.shares[e].a) > 0; });
}

Contact SceneContacts::contact_at(const Anchor& anchor, std::uint64_t key) const {
  const auto e = static_cast<std::size_t>(pair_number(key));
  const Entry& entry = pairs_[e];
  const ContactPair indices = entry.pair.indices();
  return entry.pair.at(key, pose(anchor.bodies, indices.body, entry.a), pose(anchor.bodies, indices.other, entry.b),
                       anchor.shares[e]);
}

void SceneContacts::find_ahead(const BodyStates& states, double age, LocalContacts& around) {
  keys_.clear();
  near_.clear();
  for (std::size_t j = 0; j < anchor_count_; ++j) {
    anchors_[j].bodies = moved_on(states, age + static_cast<double>(j) * anchor_time_);
    find_at(j);
  }
  fill_shares();
  prefer_lasting_sides();
  std::sort(keys_.begin(), keys_.end());
  keys_.erase(std::unique(keys_.begin(), keys_.end()), keys_.end());
  around_.clear();
  for (const std::uint64_t key : keys_) {
    if (!counts(key)) continue;
    around_.contact.push_back(contact_at(anchors_[anchor_count_ / 2], key));
    around_.pair.push_back(pairs_[static_cast<std::size_t>(pair_number(key))].pair.indices());
    around_.key.push_back(key);
  }
  local_reduction_.reduce(around_, local_set_);

  around.anchors = static_cast<std::int32_t>(anchor_count_);
  around.bodies = states.count;
  around.count = local_set_.count;
  for (std::size_t j = 0; j < anchor_count_; ++j) around.X_WB[j] = anchors_[j].bodies.X_WB;
  for (std::size_t i = 0; i < static_cast<std::size_t>(around.count); ++i) {
    const std::size_t from = local_reduction_.kept()[i];
    const double before = around_.contact[from].weight;
    // One that stands for others does so at every anchor.
    const double stands_for = before > 0 ? local_set_.contact[i].weight / before : 1;
    around.pair[i] = around_.pair[from];
    for (std::size_t j = 0; j < anchor_count_; ++j) {
      around.contact[i][j] = contact_at(anchors_[j], around_.key[from]);
      around.contact[i][j].weight *= stands_for;
    }
  }
}

}  // namespace tactor
