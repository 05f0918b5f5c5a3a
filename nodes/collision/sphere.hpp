// collision.sphere: the contacts of a sphere tool with fixed meshes and spheres.
#pragma once

#include <optional>
#include <vector>

#include "nodes/collision/collision_node.hpp"
#include "nodes/collision/exact_distance.hpp"

namespace tactor {

/// One contact of weight 1 for each fixed body whose surface is nearer than `margin` (m) to the sphere's: the point of
/// the sphere that is deepest, along the gradient of the body's signed distance at the centre. Throws InputError where
/// the tool is no sphere or a mesh is no solid.
class SphereCollision final : public CollisionNode {
 public:
  struct Params {
    double margin = 0;  ///< m
  };
  SphereCollision(const Params& params, const NodeContext& context);
  static NodeInfo declare();

  void query(const Pose& X_WT, ContactSet& set) override;

 private:
  struct Obstacle {
    Pose X_WS;
    Material material;                      // combined with the tool's
    std::optional<ExactDistance> distance;  // of a mesh
    double radius = 0;                      // m, of a sphere
    Nearest last;                           // of the mesh, at `asked_at`
    Vec3 asked_at;
  };
  [[nodiscard]] std::optional<Nearest> nearest(Obstacle& obstacle, const Vec3& p_SC) const;

  Params params_;
  double radius_ = 0;
  std::vector<Obstacle> obstacles_;
};

}  // namespace tactor
