// A body of the scene as collision sees it: its distance, its samples and a sphere about it.
#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <string>

#include "framework/core/scene.hpp"
#include "nodes/collision/contact_samples.hpp"
#include "nodes/collision/signed_distance.hpp"
#include "nodes/scene/mesh.hpp"

namespace tactor {

/// Makes the distance of a mesh; errors begin with the name.
using MakeMeshDistance =
    std::function<std::unique_ptr<SignedDistance>(const TriangleMesh& mesh, const std::string& name)>;

struct ContactBody {
  /// Throws InputError, naming the body, where its mesh or the spacing (m) cannot be used.
  ContactBody(const Body& body, double spacing, const MakeMeshDistance& make_distance);

  Shape shape;
  Motion motion;
  Pose X_WB;  ///< where the scene puts it
  Material material;
  std::unique_ptr<SignedDistance> distance;
  ContactSamples samples;
  Vec3 p_BM;         ///< m, the middle of a sphere that the body lies in
  double reach = 0;  ///< m, the radius of that sphere; infinite for a plane
};

}  // namespace tactor
