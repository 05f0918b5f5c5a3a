// The contacts of every two bodies of a scene that can meet: what exact, sdf and primitive collision share.
#pragma once

#include <vector>

#include "nodes/collision/body_pair.hpp"
#include "nodes/collision/collision_node.hpp"

namespace tactor {

/// Twice, because a body may be gaining speed.
inline constexpr double default_look_ahead = 2;

struct PairParams {
  double margin = 0;   ///< m
  double spacing = 0;  ///< m
  double look_ahead = 0;
  std::int32_t max_contacts = ContactSet::capacity;
};

/// Where a body comes that goes on at V (m/s, rad/s) for `ahead` seconds, its turn up to half a radian. It stays where
/// it is where V is not finite.
Course course_of(const Pose& X, const Twist& V, double ahead);

/// Looks at each pair of a moving body with a fixed one and of two moving bodies, as BodyPair does, and never at two
/// fixed ones. A contact is reported where the distance is below `margin`, with the pair that it belongs to: the body
/// that comes first in Scene::moving() is the moving one, T of the contact, and its normal points to that body.
/// So is one that the bodies' motion will make within `look_ahead` periods, going on at their velocities, a turn up to
/// half a radian (see BodyPair): between two queries a fast body would else go deep before its contact is found, and
/// the surface would give back what nobody put in. Bodies that move by less than the margin in that time cannot.
/// Contacts stand in the order of pairs, sides and samples; beyond `max_contacts` ContactReduction chooses. Throws
/// InputError where a mesh is no solid. Queries allocate nothing once they have met the most contacts, but for
/// collision.exact, whose search does.
class PairCollision : public CollisionNode {
 public:
  using CollisionNode::query;
  void query(const BodyStates& bodies, double period, ContactSet& set) final;

 protected:
  PairCollision(const PairParams& params, const NodeContext& context, const MakeMeshDistance& make_distance);

 private:
  [[nodiscard]] Course course(const BodyStates& bodies, std::size_t body, double ahead) const;

  struct Entry {
    std::size_t a, b;  // indices into bodies_
    BodyPair pair;
  };
  double look_ahead_;
  std::vector<ContactBody> bodies_;  // those that move first, in the order of Scene::moving()
  std::vector<Entry> pairs_;
  FoundContacts found_;
  ContactReduction reduction_;
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
  declaration.template real<double>(
      "look_ahead", &N::Params::look_ahead,
      {.doc = "contacts beyond the margin are found that the motion makes within this many times the last period of "
              "physics; 0: none",
       .default_value = default_look_ahead,
       .min = 0,
       .max = 10});
  declaration.template integer<std::int32_t>(
      "max_contacts", &N::Params::max_contacts,
      {.doc = "contacts sent at most; of more, some that are spread out stand for all, with the same force and torque",
       .default_value = ContactSet::capacity,
       .min = 8,
       .max = ContactSet::capacity});
}

}  // namespace tactor
