// The contacts of every two bodies of a scene that can meet: what exact, sdf and primitive collision share.
#pragma once

#include <vector>

#include "nodes/collision/body_pair.hpp"
#include "nodes/collision/collision_node.hpp"

namespace tactor {

struct PairParams {
  double margin = 0;   ///< m
  double spacing = 0;  ///< m
};

/// Looks at each pair of a moving body with a fixed one and of two moving bodies, as BodyPair does, and never at two
/// fixed ones. A contact is reported where the distance is below `margin`, with the pair that it belongs to: the body
/// that comes first in Scene::moving() is the moving one, T of the contact, and its normal points to that body.
/// Contacts stand in the order of pairs, sides and samples; beyond the capacity of a ContactSet the deepest are kept,
/// with weights raised so that sum(weight * depth) stays what it was; a flat contact needs a spacing coarse enough not
/// to fill the set, or its pressure gathers at one side. Throws InputError where a mesh is no solid.
class PairCollision : public CollisionNode {
 public:
  using CollisionNode::query;
  void query(const BodyStates& bodies, ContactSet& set) final;

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
  std::vector<Contact> found_;
  std::vector<ContactPair> of_pair_;  // of each found contact
  std::vector<std::size_t> order_;
};

/// Adds what all these nodes have to the declaration of N.
template <class N>
void declare_pairs(Declare<N>& declaration) {
  declare_collision(declaration);
  declaration.template real<double>(
      "spacing", &N::Params::spacing,
      {.doc = "longest distance between contact samples; 0: of a mesh the vertices only, of a box an eighth of its "
              "longest edge, of a capsule 0.28 of its radius",
       .unit = "m",
       .default_value = 0,
       .min = 0,
       .max = 1});
}

}  // namespace tactor
