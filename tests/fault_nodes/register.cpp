// The entry of libtactor_fault.so.
#include "framework/node/register_nodes.hpp"
#include "tests/fault_nodes/device.hpp"

TACTOR_NODES(registry) {
  registry.add<tactor::fault::Stall>();
  registry.add<tactor::fault::Throws>();
  registry.add<tactor::fault::Aborts>();
  registry.add<tactor::fault::NotFinite>();
  registry.add<tactor::fault::Device>();
}
