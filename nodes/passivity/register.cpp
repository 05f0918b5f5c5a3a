#include "framework/node/register_nodes.hpp"
#include "nodes/passivity/controller.hpp"
#include "nodes/passivity/energy_bound.hpp"
#include "nodes/passivity/waves.hpp"

TACTOR_NODES(registry) {
  registry.add<tactor::PassivityController>();
  registry.add<tactor::EnergyBound>();
  registry.add<tactor::Waves>();
}
