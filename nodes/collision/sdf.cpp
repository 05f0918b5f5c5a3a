#include "nodes/collision/sdf.hpp"

namespace tactor {

SdfCollision::SdfCollision(const Params& params, const NodeContext& context)
    : PairCollision(params, context, cell_distances(params, context.notes)) {}

NodeInfo SdfCollision::declare() {
  Declare<SdfCollision> d("collision.sdf", "Exact contacts of bodies of any shape, meshes prepared by cells.");
  d.details(
      "Points of either surface against the other's exact signed distance, culled by spheres that remember how far "
      "they are out of reach. A query does work in proportion to the penetrating contacts. Thin parts must be thicker "
      "than the deepest penetration: beyond the middle of a part the nearest surface is the far one.");
  declare_pairs(d);
  d.cheaper("collision.primitive");
  declare_cells(d, CellOptions{}.resolution);
  d.check([](const Params& params, const NodeContext& context) { check_cells(params, params, context); });
  // As exact, and less memory; whether there is less to compute depends on the mesh.
  d.coarser("resolution", {std::int64_t{64}, std::int64_t{32}, std::int64_t{16}});
  return d.info();
}

}  // namespace tactor
