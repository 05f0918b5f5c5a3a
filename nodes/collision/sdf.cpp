#include "nodes/collision/sdf.hpp"

namespace tactor {

SdfCollision::SdfCollision(const Params& params, const NodeContext& context)
    : PairCollision(params, context, [&params](const TriangleMesh& mesh, const std::string& name) {
        return std::make_unique<CellDistance>(mesh, name, params);
      }) {}

NodeInfo SdfCollision::declare() {
  Declare<SdfCollision> d("collision.sdf", "Exact contacts of bodies of any shape, meshes prepared by cells.");
  d.details(
      "Points of either surface against the other's exact signed distance, culled by spheres that remember how far "
      "they are out of reach. A query does work in proportion to the penetrating contacts. Thin parts must be thicker "
      "than the deepest penetration: beyond the middle of a part the nearest surface is the far one. With spacing 0 "
      "only the vertices of a mesh touch; large faces need a spacing.");
  declare_pairs(d);
  d.integer<std::int32_t>(
      "resolution", &Params::resolution,
      {.doc = "cells along the longest side of a mesh", .default_value = 160, .min = 8, .max = 1024});
  d.real<double>("band", &Params::band,
                 {.doc = "distance from a mesh's surface within which cells list their nearest faces",
                  .unit = "m",
                  .default_value = 0.003,
                  .min = 0,
                  .max = 0.1});
  return d.info();
}

}  // namespace tactor
