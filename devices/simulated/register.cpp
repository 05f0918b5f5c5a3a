#include "devices/mouse/mouse.hpp"
#include "devices/simulated/simulated.hpp"
#include "framework/node/register_nodes.hpp"

TACTOR_NODES(registry) {
  registry.add<tactor::SimulatedDevice>();
  registry.add<tactor::MouseDevice>();
}
