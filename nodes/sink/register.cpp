#include "framework/node/register_nodes.hpp"
#include "nodes/sink/metrics.hpp"

TACTOR_NODES(registry) {
  registry.add<tactor::Metrics>();
}
