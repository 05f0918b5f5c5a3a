// A body of the scene as collision sees it: its distance, its samples and a sphere about it.
#pragma once

#include <limits>
#include <memory>
#include <string>

#include "framework/core/scene.hpp"
#include "nodes/physics/contact/contact_samples.hpp"
#include "nodes/physics/geometry/mesh_distance.hpp"
#include "nodes/physics/mesh/bounds.hpp"

namespace tactor {

/// How finely a body is sampled.
struct Sampling {
  bool mesh = true;  ///< whether a mesh has samples; all other shapes do
  double given = 0;  ///< m, the spacing; 0: that of the shape
  /// m, the finest usual_spacing of what it may meet, which that of the shape is not coarser than
  double others = std::numeric_limits<double>::infinity();
};

struct ContactBody {
  /// `given`: the spacing of samples, 0: that of the shape; it and `reach` in m; without `sampled` a mesh has no
  /// samples; `notes` as for load_body_mesh. Throws InputError, naming the body, where its mesh or the spacing cannot
  /// be used.
  ContactBody(const Body& body, double given, bool sampled, double reach, const MakeMeshDistance& make_distance,
              Notes* notes);
  /// The same with what load_body_mesh returns, or no mesh for another shape.
  ContactBody(const Body& body, const TriangleMesh& mesh, const Sampling& sampling, double reach,
              const MakeMeshDistance& make_distance);

  std::string name;
  Shape shape;
  Motion motion;
  Pose X_WB;  ///< where the scene puts it
  Material material;
  std::shared_ptr<const SignedDistance> distance;
  ContactSamples samples;
  Bounds box;         ///< about it, in its frame; without end for a plane
  Vec3 p_BM;          ///< m, the middle of a sphere that the body lies in
  double radius = 0;  ///< m, of that sphere; infinite for a plane
  /// m, between samples where no spacing is given; 0 where there is no such thing
  double spacing = 0;
};

/// The spacing that a body's shape suggests where none is given: an eighth of the longest side of a mesh, else
/// default_spacing; m.
double usual_spacing(const Shape& shape, const TriangleMesh& mesh);

}  // namespace tactor
