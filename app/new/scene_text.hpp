// The text of a new scene.
#pragma once

#include <optional>
#include <string>

#include "app/new/touch_path.hpp"
#include "framework/core/scene.hpp"

namespace tactor {

/// What a new scene is made of. Lengths in m, in the world's frame, whose origin is the middle of the body's bounds.
struct NewScene {
  std::string name;
  std::string mesh;             ///< file beside the scene; empty: a box of the size `box`
  std::string mesh_note;        ///< a comment for the line of the mesh
  std::optional<double> scale;  ///< m that one unit of the file is
  Vec3 box;
  Vec3 p_WB;                    ///< of the body
  double longest = 0;           ///< side of the bounds
  std::optional<double> young;  ///< Pa, of a body that deforms; absent: a rigid one
  HalfSpaceRegion held;         ///< where a body that deforms is held
  double radius = 0;            ///< of the tool
  TouchPath path;               ///< of the tool's middle
};

/// `scene.yaml`: scene, device, physics, metrics and recording, the force held.
std::string scene_text(const NewScene& scene);
/// `METHOD.yaml`: the same by a method of graphs/methods.
std::string method_text(const std::string& name, const std::string& method);

}  // namespace tactor
