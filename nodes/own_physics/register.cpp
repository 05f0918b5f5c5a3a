#include "framework/node/register_nodes.hpp"
#include "nodes/own_physics/external.hpp"

TACTOR_NODES(registry) {
  registry.add<tactor::ExternalPhysics>();
}
