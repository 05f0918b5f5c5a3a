#include "nodes/collision/auto.hpp"

#include "nodes/collision/exact.hpp"
#include "nodes/collision/none.hpp"
#include "nodes/collision/primitive.hpp"
#include "nodes/collision/sdf.hpp"

namespace tactor {

namespace {

const char* shape_name(const Body& body) {
  static constexpr const char* names[] = {"a mesh", "a sphere", "a capsule", "a box", "a plane"};
  static_assert(std::variant_size_v<Shape> == std::size(names));
  return names[body.shape.index()];
}

}  // namespace

Resolution AutoCollision::choose(const Scene& scene) {
  static const NodeInfo none = NoCollision::declare();
  static const NodeInfo primitive = PrimitiveCollision::declare();
  static const NodeInfo sdf = SdfCollision::declare();
  if (std::string reason = nothing_to_hit(scene); !reason.empty()) return {&none, reason};
  std::string shapes;
  for (const std::size_t i : scene.moving()) {
    const Body& body = scene.bodies[i];
    const std::string is = "the moving body " + body.name + " is " + shape_name(body);
    if (body.mesh() != nullptr) return {&sdf, is};
    shapes += (shapes.empty() ? "" : ", ") + is;
  }
  return {&primitive, shapes};
}

NodeInfo AutoCollision::declare() {
  // The ports and parameters that all have.
  NodeInfo info = ExactCollision::declare();
  info.type = "collision.auto";
  info.summary = "The collision that suits the scene: none, primitive or sdf.";
  info.details =
      "It takes collision.none if nothing can touch, collision.primitive if no mesh moves, and collision.sdf "
      "otherwise. `tactor check --explain` and the summary of a run name the choice and its reason. The node keeps the "
      "costs and the lane that the graph gives it.";
  info.nature = StandIn{choose};
  return info;
}

}  // namespace tactor
