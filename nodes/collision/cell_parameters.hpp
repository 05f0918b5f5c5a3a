// The parameters of nodes that prepare meshes by cells.
#pragma once

#include "nodes/collision/cell_distance.hpp"
#include "nodes/collision/pair_collision.hpp"

namespace tactor {

inline MakeMeshDistance make_cells(const CellOptions& options) {
  return [options](const TriangleMesh& mesh, const std::string& name) {
    return std::make_unique<CellDistance>(mesh, name, options);
  };
}

/// Adds CellOptions to the declaration of N.
template <class N>
void declare_cells(Declare<N>& declaration) {
  declaration
      .template integer<std::int32_t>(
          "resolution", &N::Params::resolution,
          {.doc = "cells along the longest side of a mesh", .default_value = 160, .min = 8, .max = 1024})
      .template real<double>("band", &N::Params::band,
                             {.doc = "distance from a mesh's surface within which cells list their nearest faces",
                              .unit = "m",
                              .default_value = 0.003,
                              .min = 0,
                              .max = 0.1});
}

}  // namespace tactor
