#include "framework/node/register_nodes.hpp"
#include "nodes/collision/auto.hpp"
#include "nodes/collision/exact.hpp"
#include "nodes/collision/none.hpp"
#include "nodes/collision/primitive.hpp"
#include "nodes/collision/sdf.hpp"

TACTOR_NODES(registry) {
  registry.add<tactor::AutoCollision>();
  registry.add<tactor::ExactCollision>();
  registry.add<tactor::NoCollision>();
  registry.add<tactor::PrimitiveCollision>();
  registry.add<tactor::SdfCollision>();
}
