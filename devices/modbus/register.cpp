#include "devices/modbus/actuator.hpp"
#include "framework/node/register_nodes.hpp"

TACTOR_NODES(registry) {
  registry.add<tactor::modbus::Actuator>();
}
