// The parameters of nodes that prepare meshes by cells.
#pragma once

#include <algorithm>

#include "nodes/collision/cell_cache.hpp"
#include "nodes/collision/pair_collision.hpp"
#include "nodes/scene/bounds.hpp"

namespace tactor {

/// Cells with lists as far as `reach`, where balls are measured from, but no farther than an eighth of the mesh's
/// length, beyond which most of its box would have them; the tree answers there.
/// Made once and kept in the cache; `notes` as for load_body_mesh.
inline MakeMeshDistance make_cells(const CellOptions& options, Notes* notes) {
  return [options, notes](const TriangleMesh& mesh, double reach) {
    CellOptions wide = options;
    wide.band = std::min(std::max(options.band, reach), bounds_of(mesh).longest() / 8);
    return std::make_unique<CellDistance>(cached_cell_distance(mesh, wide, cell_cache(), notes));
  };
}

/// Refuses and notes what a PairCollision with cells of these options does, without making cells that no mesh could
/// have too many of.
void check_cells(const PairParams& params, const CellOptions& options, const NodeContext& context);

/// Adds CellOptions to the declaration of N, with that resolution where a graph gives none.
template <class N>
void declare_cells(Declare<N>& declaration, int resolution) {
  declaration
      .template integer<std::int32_t>(
          "resolution", &N::Params::resolution,
          {.doc = "cells along the longest side of a mesh", .default_value = resolution, .min = 8, .max = 1024})
      .template real<double>("band", &N::Params::band,
                             {.doc = "distance from a mesh's surface within which cells list their nearest faces; more "
                                     "where a ball of larger radius may touch it, less in a mesh that is shorter than "
                                     "eight of it",
                              .unit = "m",
                              .default_value = CellOptions{}.band,
                              .min = 0,
                              .max = 0.1})
      .unread_when({"resolution", "band"}, [](const typename N::Params&, const ParamUse& use) {
        const auto& bodies = use.scene->bodies;
        const bool any = std::any_of(bodies.begin(), bodies.end(), [](const Body& b) { return b.mesh() != nullptr; });
        return std::string(any ? "" : "no body is a mesh");
      });
}

}  // namespace tactor
