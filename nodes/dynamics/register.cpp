#include "framework/node/register_nodes.hpp"
#include "nodes/dynamics/auto.hpp"
#include "nodes/dynamics/deformable.hpp"
#include "nodes/dynamics/quasistatic.hpp"
#include "nodes/dynamics/rigid.hpp"
#include "nodes/dynamics/translation.hpp"

TACTOR_NODES(registry) {
  registry.add<tactor::AutoDynamics>();
  registry.add<tactor::DeformableDynamics>();
  registry.add<tactor::RigidDynamics>();
  registry.add<tactor::TranslationDynamics>();
  registry.add<tactor::QuasistaticDynamics>();
}
