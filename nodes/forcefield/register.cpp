#include "framework/node/registry.hpp"
#include "nodes/forcefield/grid.hpp"
#include "nodes/forcefield/rbf.hpp"

TACTOR_NODES(registry) {
  registry.add<tactor::GridForceField>();
  registry.add<tactor::RbfForceField>();
}
