// The contacts of every two bodies of a scene that can meet: what exact, sdf and primitive collision share.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "nodes/collision/body_pair.hpp"
#include "nodes/collision/collision_node.hpp"

namespace tactor {

struct PairParams {
  double margin = 0;   ///< m
  double spacing = 0;  ///< m
  std::int32_t max_contacts = ContactSet::capacity;
  std::int32_t local_contacts = 24;
  std::int32_t anchors = 3;
  double anchor_time = 0;  ///< s
};

/// Looks at each pair of a moving body with a fixed one and of two moving bodies, as BodyPair does, and never at two
/// fixed ones. A contact is reported where the distance is below `margin`, with the pair that it belongs to: the body
/// that comes first in Scene::moving() is the moving one, T of the contact, and its normal points to that body.
/// Contacts stand in the order of pairs, sides and samples; beyond `max_contacts` ContactReduction chooses. Throws
/// InputError where a mesh is no solid. Queries allocate nothing once they have met the most contacts, but for
/// collision.exact, whose search does.
class PairCollision : public CollisionNode {
 public:
  using CollisionNode::query;
  void query(const BodyStates& bodies, ContactSet& set) final;
  /// The anchors are where the bodies are by now, and where they will be `anchor_time` and twice that later. Every
  /// sample within the margin at one of them is a contact, looked up at all. Of more than `local_contacts`,
  /// ContactReduction chooses by the middle one.
  void query_ahead(const BodyStates& bodies, double age, LocalContacts& around) final;

 protected:
  PairCollision(const PairParams& params, const NodeContext& context, const MakeMeshDistance& make_distance);

  /// How many queries there were, and how many met penetrating contacts; that none did is said in words.
  void report(Report& report) const override;

 private:
  /// Adds what makes contacts doubtful before anything has moved (doubts.hpp).
  void tell_doubts(const Scene& scene, double spacing, const HandPath* hand, Notes& notes) const;
  [[nodiscard]] const Pose& pose(const BodyStates& bodies, std::int32_t index, std::size_t body) const;

  struct Entry {
    std::size_t a, b;  // indices into bodies_
    BodyPair pair;
  };
  std::vector<ContactBody> bodies_;  // those that move first, in the order of Scene::moving()
  std::vector<Entry> pairs_;
  FoundContacts found_;
  ContactReduction reduction_;
  /// What query_ahead looked at.
  struct Anchor {
    BodyStates bodies;
    std::vector<BodyPair::Shares> shares;  // by pair
  };
  void find_at(Anchor& anchor);
  void fill_shares();
  [[nodiscard]] Contact contact_at(const Anchor& anchor, std::uint64_t key) const;
  [[nodiscard]] std::span<Anchor> anchors() { return std::span(anchors_).first(anchor_count_); }

  std::size_t anchor_count_;
  double anchor_time_;  // s
  std::array<Anchor, LocalContacts::max_anchors> anchors_;
  FoundContacts found_ahead_;        // at one anchor
  std::vector<std::uint64_t> keys_;  // of all anchors, sorted
  FoundContacts around_;             // at the middle one
  ContactReduction local_reduction_;
  ContactSet local_set_;
};

/// Whether a body of the scene has contact samples whose distances `spacing` sets: a box or a capsule that meets
/// another body, or a mesh that meets one that is no ball.
bool has_spaced_samples(const Scene& scene);

/// Adds what all these nodes have to the declaration of N.
template <class N>
void declare_pairs(Declare<N>& declaration) {
  declare_collision(declaration);
  declaration.template real<double>(
      "spacing", &N::Params::spacing,
      {.doc =
           "how far contact samples may be apart. Of a mesh, every point of the surface has one of the same side "
           "within this, so that no more than this of a depth is missed, and far less where faces lie on each other; "
           "0: all vertices, and points between them where an edge is longer than an eighth of the mesh's longest "
           "side. Of a box or a capsule, the longest distance between neighbours; 0: an eighth of the longest edge, "
           "0.28 of the radius",
       .unit = "m",
       .default_value = 0,
       .min = 0,
       .max = 1});
  declaration.template integer<std::int32_t>(
      "max_contacts", &N::Params::max_contacts,
      {.doc = "contacts sent at most; of more, some that are spread out stand for all, with the same force and torque",
       .default_value = ContactSet::capacity,
       .min = 8,
       .max = ContactSet::capacity});
  declaration.template integer<std::int32_t>(
      "local_contacts", &N::Params::local_contacts,
      {.doc = "the same of the output `local`",
       .default_value = 24,
       .min = 4,
       .max = LocalContacts::capacity,
       .in_reference = 24});  // nothing reads `local` there: one reference run serves all values
  declaration.template integer<std::int32_t>(
      "anchors", &N::Params::anchors,
      {.doc = "poses that `local` is looked up at: now, and where the velocities lead",
       .default_value = 3,
       .min = 1,
       .max = LocalContacts::max_anchors,
       .in_reference = 3});
  declaration.template real<double>(
      "anchor_time", &N::Params::anchor_time,
      {.doc =
           "time between them, about the physics period in contact: a result is in use from one to two periods after "
           "its query",
       .unit = "s",
       .default_value = 0.015,
       .min = 0,
       .max = 0.1});
  using P = typename N::Params;
  declaration
      .unread_when({"local_contacts", "anchors", "anchor_time"},
                   [](const P&, const ParamUse& use) {
                     return std::string(use.is_read("local") ? "" : "nothing reads the output local");
                   })
      .unread_when({"spacing"}, [](const P&, const ParamUse& use) {
        return std::string(has_spaced_samples(*use.scene) ? "" : "no body has contact samples with distances between");
      });
  declaration.coarser("margin", {1e-3, 5e-4, 2e-4})
      .coarser("spacing", {5e-4, 1e-3, 2e-3, 4e-3, 8e-3})
      .coarser("max_contacts", {std::int64_t{64}, std::int64_t{32}, std::int64_t{16}, std::int64_t{8}})
      .coarser("local_contacts", {std::int64_t{12}, std::int64_t{8}, std::int64_t{4}})
      .coarser("anchors", {std::int64_t{2}, std::int64_t{1}});
}

}  // namespace tactor
