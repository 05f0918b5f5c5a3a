#include "nodes/collision/exact.hpp"

namespace tactor {

ExactCollision::ExactCollision(const Params& params, const NodeContext& context)
    : PairCollision(params, context, exact_distances()) {}

NodeInfo ExactCollision::declare() {
  Declare<ExactCollision> d("collision.exact", "Exact contacts of bodies of any shape, by a search of all faces.");
  d.details(
      "It finds the same contacts as collision.sdf, without the cells that make that one fast. It tests points of "
      "either surface against the exact signed distance of the other (CGAL's AABB tree, angle-weighted "
      "pseudo-normals). Use it for meshes that are used only once, or to check the cells.");
  declare_pairs(d);
  d.cheaper("collision.primitive").cheaper("collision.sdf");
  return d.info();
}

}  // namespace tactor
