// How far a repair moved a surface, and what of it that leaves out.
#pragma once

#include <cstddef>
#include <vector>

#include "nodes/physics/mesh/mesh_change.hpp"
#include "nodes/physics/meshing/surface_rework.hpp"

namespace tactor {

/// A file's surface, and what was done to it. Lengths are in the unit of the file.
struct ReworkedSurface {
  const std::vector<Corners>& triangles;
  const std::vector<std::size_t>& numbers;  ///< of the face in the file, for each triangle
  const std::vector<Corners>& patches;      ///< what fills its holes
  bool united = false;                      ///< parts of it may lie inside now
  double diagonal = 0;
};

/// Measures the way from `old` to `change.mesh`. `change.removed` has been filled; the rest of what is measured is not.
void measure_change(const ReworkedSurface& old, MeshChange& change);

}  // namespace tactor
