#include "framework/node/registry.hpp"
#include "nodes/sink/metrics.hpp"

TACTOR_NODES(registry) {
  registry.add<tactor::Metrics>();
}
