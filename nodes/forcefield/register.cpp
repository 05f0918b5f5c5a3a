#include "framework/node/registry.hpp"
#include "nodes/forcefield/grid.hpp"
#ifdef TACTOR_WITH_CGAL
#include "nodes/forcefield/rbf.hpp"
#endif

TACTOR_NODES(registry) {
  registry.add<tactor::GridForceField>();
#ifdef TACTOR_WITH_CGAL
  registry.add<tactor::RbfForceField>();
#endif
}
