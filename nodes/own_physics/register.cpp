#include "framework/node/register_nodes.hpp"
#include "nodes/own_physics/external.hpp"
#include "nodes/own_physics/mujoco.hpp"

TACTOR_NODES(registry) {
  registry.add<tactor::ExternalPhysics>();
  registry.add<tactor::MujocoPhysics>();
}
