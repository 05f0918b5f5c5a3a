// The contacts of every two bodies of a scene that can meet: what exact, sdf and primitive collision share.
#pragma once

#include <vector>

#include "nodes/collision/body_pair.hpp"
#include "nodes/collision/collision_node.hpp"

namespace tactor {

struct PairParams {
  double margin = 0;   ///< m
  double spacing = 0;  ///< m
  std::int32_t max_contacts = ContactSet::capacity;
  std::int32_t local_contacts = 24;
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
  /// Every sample that is within the margin at one of the anchors is a contact, looked up at the others too. Beyond
  /// `local_contacts` ContactReduction chooses by the middle one.
  void query_ahead(std::span<const BodyStates> anchors, LocalContacts& around) final;

 protected:
  PairCollision(const PairParams& params, const NodeContext& context, const MakeMeshDistance& make_distance);

 private:
  [[nodiscard]] const Pose& pose(const BodyStates& bodies, std::int32_t index, std::size_t body) const;

  struct Entry {
    std::size_t a, b;  // indices into bodies_
    BodyPair pair;
  };
  std::vector<ContactBody> bodies_;  // those that move first, in the order of Scene::moving()
  std::vector<Entry> pairs_;
  FoundContacts found_;
  ContactReduction reduction_;
  /// What query_ahead found at one anchor.
  struct Ahead {
    FoundContacts found;
    std::vector<BodyPair::Shares> shares;  // by pair
  };
  std::array<Ahead, LocalContacts::max_anchors> ahead_;
  std::vector<std::uint64_t> keys_;  // of all anchors, sorted
  FoundContacts around_;             // at the middle one
  ContactReduction local_reduction_;
  ContactSet local_set_;
};

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
      {.doc = "the same of the output `local`", .default_value = 24, .min = 4, .max = LocalContacts::capacity});
}

}  // namespace tactor
