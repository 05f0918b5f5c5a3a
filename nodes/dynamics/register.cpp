#include "framework/node/registry.hpp"
#include "nodes/dynamics/rigid.hpp"

TACTOR_NODES(registry) {
  registry.add<tactor::RigidDynamics>();
}
