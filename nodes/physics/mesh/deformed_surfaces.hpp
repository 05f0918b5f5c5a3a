// Where the surfaces of deformable bodies are, for those who show them.
#pragma once

#include "framework/core/describe.hpp"
#include "framework/core/shared_array.hpp"

namespace tactor {

/// A place of a node, in single precision: it is looked at, not computed with.
struct ShownPoint {
  std::array<float, 3> p_W{};  ///< m
};

/// The surface nodes of all deformable bodies, in the order of Scene::deformable(); of a body, those that its boundary
/// faces use, in the order of its mesh.
struct DeformedSurfaces {
  SharedArray<ShownPoint> nodes;
};

template <>
inline const MessageType& message_type<ShownPoint>() {
  static const MessageType type = Describe<ShownPoint>("ShownPoint", "W").field("p_W", "m", &ShownPoint::p_W).type();
  return type;
}

template <>
inline const MessageType& message_type<DeformedSurfaces>() {
  static const MessageType type =
      Describe<DeformedSurfaces>("DeformedSurfaces", "W").field("nodes", &DeformedSurfaces::nodes).type();
  return type;
}

}  // namespace tactor
