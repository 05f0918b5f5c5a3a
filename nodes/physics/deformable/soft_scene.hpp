// The deformable bodies of a scene as elements and as a surface.
#pragma once

#include <vector>

#include "framework/core/scene.hpp"
#include "nodes/physics/contact/soft_contacts.hpp"
#include "nodes/physics/deformable/deformable_options.hpp"
#include "nodes/physics/deformable/elastic_model.hpp"
#include "nodes/physics/mesh/body_mesh.hpp"

namespace tactor {

struct SoftScene {
  ElasticModel model;
  /// Over the nodes of the model. A face of a quadratic element is four, through its mid-edge nodes.
  SoftSurface surface;
  /// Nodes of the surface, each once, in ascending order.
  std::vector<int> surface_nodes;
  /// Those of them that are no mid-edge nodes: what is shown.
  std::vector<int> shown_nodes;
};

/// Throws InputError where nothing deforms or a body's volume cannot be made; adds to `notes` as load_body_volume does.
SoftScene soft_scene(const Scene& scene, const DeformableOptions& options, Notes* notes);

}  // namespace tactor
