#include "framework/node/register_nodes.hpp"
#include "nodes/forcefield/grid.hpp"
#include "nodes/forcefield/proxy.hpp"
#include "nodes/forcefield/rbf.hpp"
#include "nodes/forcefield/spring.hpp"

TACTOR_NODES(registry) {
  registry.add<tactor::GridForceField>();
  registry.add<tactor::RbfForceField>();
  registry.add<tactor::SpringForceField>();
  registry.add<tactor::ProxyForceField>();
}
