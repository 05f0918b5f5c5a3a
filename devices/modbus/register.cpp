#include "devices/modbus/actuator.hpp"
#include "framework/node/registry.hpp"

TACTOR_NODES(registry) {
  registry.add<tactor::modbus::Actuator>();
}
