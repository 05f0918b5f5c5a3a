// The part of deforming surfaces around the tool, small enough to be stepped at each tick.
#pragma once

#include "framework/core/describe.hpp"
#include "framework/core/shared_array.hpp"

namespace tactor {

/// A node of a patch.
struct PatchNode {
  Vec3 p_W;  ///< m
  Vec3 v_W;  ///< m/s
  std::int64_t fixed = 0;
};

/// A face of a patch.
struct PatchFace {
  std::array<std::int32_t, 3> node{};
  std::int32_t body = 0;  ///< in Scene::deformable()
  double area = 0;        ///< m^2
};

/// A shape in which a patch moves.
struct PatchMode {
  double stiffness = 0;  ///< 1/s^2
  double damping = 0;    ///< 1/s
  double force = 0;      ///< sqrt(kg) m/s^2
  double z = 0;          ///< sqrt(kg) m
  double rate = 0;       ///< sqrt(kg) m/s
};

/// A deformable body around the tool, condensed (R. Guyan, "Reduction of stiffness and mass matrices", 1965).
struct LocalPatch {
  static constexpr int capacity = 40;    ///< nodes that move
  static constexpr int most_nodes = 48;  ///< and those that do not
  static constexpr int most_faces = 96;
  static constexpr int most_modes = 3 * 45;
  SharedArray<PatchNode> nodes;
  SharedArray<PatchFace> faces;
  SharedArray<PatchMode> modes;
  SharedArray<double> shapes;  ///< 1/sqrt(kg)
};

/// True where it is empty, or all that it lists is of 1e15 at most in its unit and fits together.
bool is_usable(const LocalPatch& patch);

template <>
const MessageType& message_type<PatchNode>();
template <>
const MessageType& message_type<PatchFace>();
template <>
const MessageType& message_type<PatchMode>();
template <>
const MessageType& message_type<LocalPatch>();

}  // namespace tactor
