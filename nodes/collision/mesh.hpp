// collision.mesh: the contacts of a mesh tool with fixed meshes.
#pragma once

#include <memory>
#include <vector>

#include "nodes/collision/collision_node.hpp"
#include "nodes/collision/exact_distance.hpp"
#include "nodes/collision/sample_tree.hpp"

namespace tactor {

/// Samples of the tool's surface against each fixed mesh, and samples of each fixed mesh against the tool, all by exact
/// signed distance. A contact is reported where the distance is below `margin`.
///   weight = share * sample area / patch area of the softer material,
/// where the shares of the two sides of a pair sum to 1, in proportion to sum(area * (margin - distance)) of each side:
/// about one half each where both are finely sampled, nearly 1 for the side that alone has samples there. The shares
/// change continuously as samples come and go. Contacts stand in the order of bodies, sides and samples; beyond the
/// capacity of a ContactSet the deepest are kept, with weights raised so that sum(weight * depth) stays what it was; a
/// flat contact needs a spacing coarse enough not to fill the set, or its pressure gathers at one side. Throws
/// InputError where a mesh is no solid or a body is a sphere.
class MeshCollision final : public CollisionNode {
 public:
  struct Params {
    double margin = 0;   ///< m
    double spacing = 0;  ///< m
  };
  MeshCollision(const Params& params, const NodeContext& context);
  static NodeInfo declare();

  void query(const Pose& X_WT, ContactSet& set) override;

 private:
  struct Obstacle {
    Pose X_WS;
    Material material;  // combined with the tool's
    std::vector<SurfaceSample> samples;
    ExactDistance distance;
    SampleTree tree;       // of its samples, against the tool
    SampleTree tool_tree;  // of the tool's samples, against it
  };
  void add_pair(Obstacle& obstacle, const Pose& X_WT);

  Params params_;
  std::vector<SurfaceSample> samples_;  // of the tool
  std::unique_ptr<ExactDistance> distance_;
  std::vector<Obstacle> obstacles_;
  std::vector<Contact> found_;
  std::vector<std::size_t> order_;
};

}  // namespace tactor
