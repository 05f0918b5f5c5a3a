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

struct ContactBody {
  /// `spacing` of samples and `reach` in m; without `sampled` a mesh has no samples; `notes` as for load_body_mesh.
  /// Throws InputError, naming the body, where its mesh or the spacing cannot be used.
  ContactBody(const Body& body, double spacing, bool sampled, double reach, const MakeMeshDistance& make_distance,
              Notes* notes);

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
};

}  // namespace tactor
