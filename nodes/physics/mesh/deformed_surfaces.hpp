// Where the surfaces of deformable bodies are, for those who show them.
#pragma once

#include "framework/core/describe.hpp"
#include "framework/core/shared_array.hpp"

namespace tactor {

/// A node of a surface that is shown.
struct ShownPoint {
  std::array<float, 3> p_W{};  ///< m
};

/// The surface nodes of all deformable bodies.
struct DeformedSurfaces {
  SharedArray<ShownPoint> nodes;
};

template <>
inline const MessageType& message_type<ShownPoint>() {
  static const MessageType type =
      Describe<ShownPoint>("ShownPoint", "W", "A node of a surface, in single precision: for display alone.")
          .field("p_W", "m", &ShownPoint::p_W, "Position of the node, measured from the origin of W.")
          .type();
  return type;
}

template <>
inline const MessageType& message_type<DeformedSurfaces>() {
  static const MessageType type =
      Describe<DeformedSurfaces>("DeformedSurfaces", "W",
                                 "The surfaces of all deformable bodies. Stamped valid for the device sample that the "
                                 "step of physics was computed against.")
          .field("nodes", &DeformedSurfaces::nodes,
                 "Nodes body after body, in the order of the graph file. Of a body they are those of its boundary "
                 "faces, in the order of its mesh.")
          .type();
  return type;
}

}  // namespace tactor
