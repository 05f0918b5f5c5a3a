#include "framework/node/register_nodes.hpp"
#include "nodes/effect/impact.hpp"
#include "nodes/effect/texture.hpp"

TACTOR_NODES(registry) {
  registry.add<tactor::Impact>();
  registry.add<tactor::Texture>();
}
