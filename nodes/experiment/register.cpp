#include "framework/node/register_nodes.hpp"
#include "nodes/experiment/observer.hpp"
#include "nodes/experiment/protocol.hpp"

TACTOR_NODES(registry) {
  registry.add<tactor::Observer>();
  registry.add<tactor::Protocol>();
}
