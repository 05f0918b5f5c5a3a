#include "devices/usb/device.hpp"
#include "framework/node/register_nodes.hpp"

TACTOR_NODES(registry) {
  registry.add<tactor::UsbDevice>();
}
