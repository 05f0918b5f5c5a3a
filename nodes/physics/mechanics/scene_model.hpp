// The moving bodies of a scene as a step sees them.
#pragma once

#include <string>

#include "framework/core/scene.hpp"
#include "nodes/physics/mechanics/system.hpp"
#include "nodes/physics/mesh/body_mesh.hpp"

namespace tactor {

/// The moving bodies in the order of Scene::moving() and the gravity. `type`: of the node that asks, for messages.
/// Throws InputError where nothing moves or a moving body's mesh is no solid; tells `notes` what was repaired.
SystemModel scene_model(const std::string& type, const Scene& scene, Notes* notes);

/// Throws ValueError where a body of the scene deforms. `does`: what the node does with rigid bodies, such as
/// `dynamics.rigid moves`; `use`: what takes its place.
void refuse_deformable(const Scene& scene, const std::string& does, const std::string& use);

/// Why a scene does not need what moves the tool, or empty where it does.
inline std::string nothing_moves(const Scene& scene) {
  return scene.tool() == nullptr ? std::string("nothing in the scene moves") : std::string();
}

}  // namespace tactor
