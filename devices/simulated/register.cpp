#include "devices/simulated/simulated.hpp"
#include "framework/node/registry.hpp"

TACTOR_NODES(registry) {
  registry.add<tactor::SimulatedDevice>();
}
