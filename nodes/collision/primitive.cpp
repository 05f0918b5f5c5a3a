#include "nodes/collision/primitive.hpp"

#include "framework/core/value_error.hpp"

namespace tactor {

namespace {

void check_moving(const Scene& scene) {
  for (const std::size_t i : scene.moving()) {
    const Body& body = scene.bodies[i];
    if (body.mesh() == nullptr) continue;
    throw ValueError("scene.bodies." + body.name + ".mesh",
                     "collision.primitive: the moving body '" + body.name +
                         "' is a mesh; expected a sphere, a capsule or a box, or use collision.sdf");
  }
}

const NodeContext& checked(const NodeContext& context) {
  check_moving(*context.scene);
  return context;
}

}  // namespace

PrimitiveCollision::PrimitiveCollision(const Params& params, const NodeContext& context)
    : PairCollision(params, checked(context), cell_distances(params, context.notes)) {}

NodeInfo PrimitiveCollision::declare() {
  Declare<PrimitiveCollision> d("collision.primitive",
                                "Exact contacts of moving spheres, capsules and boxes with bodies of any shape.");
  d.details(
      "A sphere touches a body at one point of weight 1, found from the signed distance of its centre. In a notch it "
      "touches one side at a time. A capsule of radius r and length L is sampled by balls along its axis. Its two ends "
      "weigh 1 each, and its length weighs L / (2 r) in total, whatever the spacing s. The depth found is too small by "
      "at most s^2 / (8 (r - depth)), and exact on a plane. Boxes and meshes touch as in collision.sdf.");
  declare_pairs(d);
  // A point or a few need no finer cells: a seventh of the time to make them, for a quarter more a query.
  declare_cells(d, 48);
  d.check([](const Params& params, const NodeContext& context) { check_cells(params, params, checked(context)); });
  return d.info();
}

}  // namespace tactor
