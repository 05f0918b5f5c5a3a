#include "devices/usb/device.hpp"
#include "framework/node/registry.hpp"

TACTOR_NODES(registry) {
  registry.add<tactor::UsbDevice>();
}
