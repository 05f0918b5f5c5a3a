// A box as tetrahedra.
#pragma once

#include <array>

#include "nodes/physics/mesh/tet_mesh.hpp"
#include "nodes/physics/mesh/volume_fineness.hpp"

namespace tactor {

/// How many cells along x, y and z: with edges near `fineness.edge`, or so that five tetrahedra each are near
/// `fineness.tetrahedra` while the cells are near cubes. At least 1. `size`: m.
std::array<std::size_t, 3> box_cells(const Vec3& size, const VolumeFineness& fineness);

/// Nodes of a grid, its middle at the origin, x fastest, and five tetrahedra in each cell, whose diagonals alternate
/// from cell to cell. Five and not six (Kuhn's), because all diagonals of six run one way, so that a pressed box would
/// shear; and fewer of them at a node lock less where the material keeps its volume. In cubes the smallest dihedral
/// angle is 54.7 degrees (45 for six).
TetMesh box_volume(const Vec3& size, const std::array<std::size_t, 3>& cells);

}  // namespace tactor
