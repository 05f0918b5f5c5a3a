// The weight of a scene's tool.
#pragma once

#include "framework/core/scene.hpp"

namespace tactor {

/// N, in W; zero where the scene has no tool.
inline Vec3 tool_weight(const Scene& scene) {
  const Body* tool = scene.tool();
  return tool == nullptr ? Vec3{} : tool->mass * scene.gravity_W;
}

}  // namespace tactor
