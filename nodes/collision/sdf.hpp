// collision.sdf: contacts by distances that are prepared for the space about each mesh.
#pragma once

#include "nodes/collision/cell_parameters.hpp"
#include "nodes/collision/pair_collision.hpp"

namespace tactor {

/// PairCollision with CellDistance for meshes.
class SdfCollision final : public PairCollision {
 public:
  struct Params : ContactOptions, CellOptions {};
  SdfCollision(const Params& params, const NodeContext& context);
  static NodeInfo declare();
};

}  // namespace tactor
