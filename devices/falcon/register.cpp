#include "devices/falcon/device.hpp"
#include "framework/node/registry.hpp"

TACTOR_NODES(registry) {
  registry.add<tactor::Falcon>();
}
