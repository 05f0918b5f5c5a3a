#include "framework/node/register_nodes.hpp"
#include "nodes/coupling/adaptive.hpp"
#include "nodes/coupling/dynamic.hpp"
#include "nodes/coupling/static.hpp"

TACTOR_NODES(registry) {
  registry.add<tactor::StaticCoupling>();
  registry.add<tactor::DynamicCoupling>();
  registry.add<tactor::AdaptiveCoupling>();
}
