// The parameters of nodes that prepare meshes by cells.
#pragma once

#include <algorithm>

#include "nodes/collision/pair_collision.hpp"
#include "nodes/physics/geometry/cell_cache.hpp"
#include "nodes/physics/mesh/bounds.hpp"

namespace tactor {

/// Refuses and notes what SceneContacts with cells of these options do, without making cells that no mesh could
/// have too many of.
void check_cells(const ContactOptions& contacts, const CellOptions& cells, const NodeContext& context);

/// Adds CellOptions to the declaration of N, with that resolution where a graph gives none.
template <class N>
void declare_cells(Declare<N>& declaration, int resolution) {
  declaration
      .template integer<std::int32_t>(
          "resolution", &N::Params::resolution,
          {.doc = "cells along the longest side of a mesh", .default_value = resolution, .min = 8, .max = 1024})
      .template real<double>(
          "band", &N::Params::band,
          {.doc =
               "distance from a mesh's surface within which cells list their nearest faces. It grows if a ball of "
               "larger radius may touch the mesh, and shrinks in a mesh that is shorter than eight times this distance",
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
