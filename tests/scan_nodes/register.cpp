// The entry of libtactor_scan.so.
#include "framework/node/register_nodes.hpp"
#include "tests/scan_nodes/scanner.hpp"

TACTOR_NODES(registry) {
  registry.add<tactor::scan::Source>();
  registry.add<tactor::scan::Judge>();
}
