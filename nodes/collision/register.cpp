#include "framework/node/registry.hpp"
#include "nodes/collision/mesh.hpp"
#include "nodes/collision/sphere.hpp"

TACTOR_NODES(registry) {
  registry.add<tactor::MeshCollision>();
  registry.add<tactor::SphereCollision>();
}
