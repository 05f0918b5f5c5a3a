#include "nodes/collision/exact.hpp"

namespace tactor {

ExactCollision::ExactCollision(const Params& params, const NodeContext& context)
    : PairCollision(params, context, exact_distances()) {}

NodeInfo ExactCollision::declare() {
  Declare<ExactCollision> d("collision.exact", "Exact contacts of bodies of any shape, by a search of all faces.");
  d.details(
      "What collision.sdf finds, without the cells that make it fast: points of either surface against the other's "
      "exact signed distance (CGAL's AABB tree, angle-weighted pseudo-normals). For meshes that are met once, and to "
      "check the cells by.");
  declare_pairs(d);
  d.cheaper("collision.primitive").cheaper("collision.sdf");
  return d.info();
}

}  // namespace tactor
