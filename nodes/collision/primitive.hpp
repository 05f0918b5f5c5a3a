// collision.primitive: the contacts of spheres, capsules and boxes that move.
#pragma once

#include "nodes/collision/cell_parameters.hpp"
#include "nodes/collision/pair_collision.hpp"

namespace tactor {

/// PairCollision for moving bodies that are no meshes; fixed meshes have CellDistance. Throws InputError where a mesh
/// moves.
class PrimitiveCollision final : public PairCollision {
 public:
  struct Params : ContactOptions, CellOptions {};
  PrimitiveCollision(const Params& params, const NodeContext& context);
  static NodeInfo declare();
};

}  // namespace tactor
