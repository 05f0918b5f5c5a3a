#include "nodes/physics/contact/scene_contacts.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "nodes/physics/contact/doubts.hpp"

namespace tactor {

namespace {

// Of larger contacts the first few queries allocate.
constexpr std::size_t usual_contacts = 4096;

/// Two bodies of the scene that are looked at as a pair.
bool is_pair(const Body& a, const Body& b) {
  return &a != &b && (a.motion != Motion::fixed || b.motion != Motion::fixed);
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

/// The spacing of a body's samples where none is given (0: that of its shape): of a box, not coarser than that of the
/// boxes that it may meet; of a fixed one, nor than that of the moving meshes, which are in `made`.
double spacing_by_default(const Body& body, const Scene& scene, const std::vector<ContactBody>& made) {
  const auto* box = std::get_if<BoxShape>(&body.shape);
  if (box == nullptr) return 0;
  double finest = default_spacing(*box);
  for (const Body& other : scene.bodies) {
    if (!is_pair(body, other)) continue;
    if (std::holds_alternative<BoxShape>(other.shape)) finest = std::min(finest, default_spacing(other.shape));
    // All that move have been made when the first fixed body is.
    if (other.mesh() == nullptr || body.motion != Motion::fixed) continue;
    const auto known =
        std::find_if(made.begin(), made.end(), [&](const ContactBody& b) { return b.name == other.name; });
    if (known != made.end()) finest = std::min(finest, known->box.longest() / 8);
  }
  return box_spacing(*box, finest);
}

/// Where the bodies are `time` s later if they keep their velocities.
BodyStates moved_on(const BodyStates& bodies, double time) {
  BodyStates later = bodies;
  for (std::size_t i = 0; i < static_cast<std::size_t>(bodies.count); ++i) {
    later.X_WB[i].p += time * bodies.V_WB[i].v;
    later.X_WB[i].R = from_rotation_vector(time * bodies.V_WB[i].w) * later.X_WB[i].R;
  }
  return later;
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
    const double spacing = options.spacing > 0 ? options.spacing : spacing_by_default(body, scene, bodies_);
    bodies_.emplace_back(body, spacing, is_sampled(body, scene), reach_to(body, scene, options.margin), make_distance,
                         notes);
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
  lasting_.resize(pairs_.size());
  for (Anchor& anchor : anchors_) {
    anchor.shares.reserve(pairs_.size());
    anchor.depths.reserve(pairs_.size());
  }
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

void SceneContacts::find(const BodyStates& states, ContactSet& set) {
  found_.clear();
  for (Entry& entry : pairs_) {
    const ContactPair indices = entry.pair.indices();
    entry.pair.find(pose(states, indices.body, entry.a), pose(states, indices.other, entry.b), found_);
  }
  set.bodies.count = states.count;
  std::copy_n(states.X_WB.begin(), states.count, set.bodies.X_WB.begin());
  reduction_.reduce(found_, set);
}

/// Adds the keys of the contacts at an anchor and notes what each side of a pair has there.
void SceneContacts::find_at(Anchor& anchor) {
  found_ahead_.clear();
  anchor.shares.clear();
  anchor.depths.assign(pairs_.size(), {});
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
    near_.push_back({key, c.weight * (margin_ - c.distance)});
    (is_from_b(key) ? anchor.depths[e].b : anchor.depths[e].a) += c.weight * std::max(0.0, -c.distance);
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

/// Changes the shares of pairs with samples on both sides, at each anchor, as find_ahead says. Towards the side that
/// lasts less its share falls with the 32nd power of the ratio in which it lasts: to nothing where that is below 0.8.
void SceneContacts::prefer_lasting_sides() {
  constexpr double power = 32, nothing = 1e-3;
  std::fill(lasting_.begin(), lasting_.end(), std::array<Lasting, 2>{});
  std::sort(near_.begin(), near_.end(), [](const NearSide& x, const NearSide& y) { return x.key < y.key; });
  for (std::size_t i = 0; i < near_.size();) {
    const std::uint64_t key = near_[i].key;
    double least = near_[i].extent, most = least;
    std::size_t anchors_near = 0;
    for (; i < near_.size() && near_[i].key == key; ++i, ++anchors_near) {
      least = std::min(least, near_[i].extent);
      most = std::max(most, near_[i].extent);
    }
    Lasting& side = lasting_[static_cast<std::size_t>(pair_number(key))][is_from_b(key) ? 1 : 0];
    if (anchors_near == anchor_count_) side.least += least;
    side.most += most;
  }
  for (std::size_t e = 0; e < pairs_.size(); ++e) {
    const double a = lasting_[e][0].share(), b = lasting_[e][1].share();
    // No side lasts, or one alone has samples there.
    if (!(std::max(a, b) > 0) || lasting_[e][0].most == 0 || lasting_[e][1].most == 0) continue;
    const auto preference = [&](double lasting) {
      const double p = std::pow(lasting / std::max(a, b), power);
      return p < nothing ? 0 : p;
    };
    for (Anchor& anchor : anchors()) {
      const BodyPair::Shares was = anchor.shares[e], depth = anchor.depths[e];
      const double of_a = was.a * preference(a), of_b = was.b * preference(b);
      if (!(of_a + of_b > 0)) continue;
      BodyPair::Shares is{of_a / (of_a + of_b), of_b / (of_a + of_b)};
      // The two sides do not make the same force of the same overlap, so what is left is made to push as both did.
      const auto changed = [](double from, double to) { return from > 0 ? to / from : 0; };
      const double pushes = depth.a * changed(was.a, is.a) + depth.b * changed(was.b, is.b);
      const double as_both = pushes > 0 ? std::clamp((depth.a + depth.b) / pushes, 0.5, 2.0) : 1;
      anchor.shares[e] = {as_both * is.a, as_both * is.b};
    }
  }
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
    find_at(anchors_[j]);
  }
  fill_shares();
  prefer_lasting_sides();
  std::sort(keys_.begin(), keys_.end());
  keys_.erase(std::unique(keys_.begin(), keys_.end()), keys_.end());
  around_.clear();
  for (const std::uint64_t key : keys_) {
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
