// The part of deforming surfaces around the tool, small enough to be stepped at each tick.
#pragma once

#include "framework/core/describe.hpp"
#include "framework/core/shared_array.hpp"

namespace tactor {

/// A node of a patch.
struct PatchNode {
  Vec3 p_W;                ///< m, where the result has it
  Vec3 v_W;                ///< m/s, then
  std::int64_t fixed = 0;  ///< 1: it does not move
};

/// A face of a patch, counter-clockwise as seen from outside.
struct PatchFace {
  std::array<std::int32_t, 3> node{};
  std::int32_t body = 0;  ///< in Scene::deformable()
  double area = 0;        ///< m^2, at rest
};

/// A shape in which a patch moves, of unit mass: z'' + damping z' + stiffness z = force + shape^T f, for forces f (N)
/// on the nodes, and displacements shape z of the nodes from where the result has them.
struct PatchMode {
  double stiffness = 0;  ///< 1/s^2
  double damping = 0;    ///< 1/s
  double force = 0;      ///< sqrt(kg) m/s^2, of what is strained and of weight where the result has the nodes
  double z = 0;          ///< sqrt(kg) m
  double rate = 0;       ///< sqrt(kg) m/s
};

/// What a deformable body is around the tool: n nodes of its surface, which can be touched, and m modes of the body
/// condensed onto these and a few nodes elsewhere. All other nodes follow as they do in balance (R. Guyan, "Reduction
/// of stiffness and mass matrices", 1965). Empty where nothing deforms or the tool is far away.
struct LocalPatch {
  static constexpr int capacity = 40;    ///< nodes that move
  static constexpr int most_nodes = 48;  ///< and those that do not
  static constexpr int most_faces = 96;
  static constexpr int most_modes = 3 * 45;
  SharedArray<PatchNode> nodes;  ///< n
  SharedArray<PatchFace> faces;  ///< all of whose nodes are in the patch
  SharedArray<PatchMode> modes;  ///< m: three for each node that the body is condensed onto
  SharedArray<double> shapes;    ///< 3 n x m, 1/sqrt(kg), a column a mode; zero rows for nodes that are fixed
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
