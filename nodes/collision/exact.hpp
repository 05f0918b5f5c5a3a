// collision.exact: contacts by a search of all faces, which needs no preparation of the meshes.
#pragma once

#include "nodes/collision/pair_collision.hpp"

namespace tactor {

/// PairCollision with ExactDistance for meshes.
class ExactCollision final : public PairCollision {
 public:
  struct Params : ContactOptions {};
  ExactCollision(const Params& params, const NodeContext& context);
  static NodeInfo declare();
};

}  // namespace tactor
