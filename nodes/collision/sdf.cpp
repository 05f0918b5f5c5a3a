#include "nodes/collision/sdf.hpp"

namespace tactor {

SdfCollision::SdfCollision(const Params& params, const NodeContext& context)
    : PairCollision(params, context, cell_distances(params, context.notes)) {}

NodeInfo SdfCollision::declare() {
  Declare<SdfCollision> d("collision.sdf", "Exact contacts of bodies of any shape, with meshes prepared as cells.");
  d.details(
      "It tests points of either surface against the exact signed distance of the other. Spheres that remember how far "
      "they are out of reach cull most points, so the work of a query is proportional to the penetrating contacts. A "
      "part must be thicker than the deepest penetration: beyond its middle, the nearest surface is the one on the far "
      "side.");
  declare_pairs(d);
  d.cheaper("collision.primitive");
  declare_cells(d, CellOptions{}.resolution);
  d.check([](const Params& params, const NodeContext& context) { check_cells(params, params, context); });
  // As exact, and less memory; whether there is less to compute depends on the mesh.
  d.coarser("resolution", {std::int64_t{64}, std::int64_t{32}, std::int64_t{16}});
  return d.info();
}

}  // namespace tactor
