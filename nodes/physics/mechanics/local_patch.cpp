#include "nodes/physics/mechanics/local_patch.hpp"

#include <algorithm>
#include <cmath>

namespace tactor {

template <>
const MessageType& message_type<PatchNode>() {
  static const MessageType type =
      Describe<PatchNode>("PatchNode", "W", "A surface node of a deformable body near the tool.")
          .field("p_W", "m", &PatchNode::p_W, "Position in the physics result, measured from the origin of W.")
          .field("v_W", "m/s", &PatchNode::v_W, "Velocity in the physics result.")
          .field("fixed", "1", &PatchNode::fixed, "1: the node does not move. 0: it does.")
          .type();
  return type;
}

template <>
const MessageType& message_type<PatchFace>() {
  static const MessageType type =
      Describe<PatchFace>("PatchFace", "", "A triangle between nodes of the patch.")
          .field("node", "1", &PatchFace::node, "Indices into `nodes`, counter-clockwise as seen from outside.")
          .field("body", "1", &PatchFace::body,
                 "Index of the deformable body, counted from 0 in the order of the graph file.")
          .field("area", "m^2", &PatchFace::area, "Area at rest.")
          .type();
  return type;
}

template <>
const MessageType& message_type<PatchMode>() {
  static const MessageType type =
      Describe<PatchMode>("PatchMode", "",
                          "A shape in which the patch moves, of unit mass: z'' + damping z' + stiffness z = force + "
                          "shape^T f, for forces f on the nodes. The nodes move from their place in the result by the "
                          "sum of shape z.")
          .field("stiffness", "1/s^2", &PatchMode::stiffness, "Square of the undamped angular frequency.")
          .field("damping", "1/s", &PatchMode::damping, "Factor of the rate in the equation of the mode.")
          .field("force", "kg^0.5 m/s^2", &PatchMode::force,
                 "Modal force of strain and weight where the result has the nodes.")
          .field("z", "kg^0.5 m", &PatchMode::z, "Modal displacement, 0 where the result has the nodes.")
          .field("rate", "kg^0.5 m/s", &PatchMode::rate, "Rate of change of `z`.")
          .type();
  return type;
}

template <>
const MessageType& message_type<LocalPatch>() {
  static const MessageType type =
      Describe<LocalPatch>("LocalPatch", "W",
                           "A deformable body around the tool: nodes of its surface that can be touched, and modes of "
                           "the body condensed onto these and a few nodes elsewhere. All other nodes follow as in "
                           "balance. It is empty where nothing deforms or the tool is far away. Stamped valid for the "
                           "device sample that the step of physics was computed against.")
          .field("nodes", &LocalPatch::nodes)
          .field("faces", &LocalPatch::faces, "Triangles of the surface all of whose nodes are in the patch.")
          .field("modes", &LocalPatch::modes)
          .field("shapes", "kg^-0.5", &LocalPatch::shapes,
                 "Displacements of the nodes for z = 1, mode after mode: x, y, z of each node in the order of `nodes`. "
                 "Those of fixed nodes are zero.")
          .type();
  return type;
}

namespace {

/// Of all numbers, in their units: beyond, products of them overflow.
constexpr double most_in_patch = 1e15;

/// A comparison with NaN is false.
bool fits_in_patch(double x) {
  return std::abs(x) <= most_in_patch;
}
bool fits_in_patch(const Vec3& v) {
  return fits_in_patch(v.x) && fits_in_patch(v.y) && fits_in_patch(v.z);
}

}  // namespace

bool is_usable(const LocalPatch& patch) {
  const std::size_t n = patch.nodes.size();
  const auto moving =
      std::count_if(patch.nodes.begin(), patch.nodes.end(), [](const PatchNode& node) { return node.fixed == 0; });
  if (n > LocalPatch::most_nodes || moving > LocalPatch::capacity || patch.faces.size() > LocalPatch::most_faces ||
      patch.modes.size() > LocalPatch::most_modes || patch.shapes.size() != 3 * n * patch.modes.size()) {
    return false;
  }
  const auto known = [n](std::int32_t node) { return node >= 0 && static_cast<std::size_t>(node) < n; };
  return std::all_of(patch.nodes.begin(), patch.nodes.end(),
                     [](const PatchNode& node) { return fits_in_patch(node.p_W) && fits_in_patch(node.v_W); }) &&
         std::all_of(patch.faces.begin(), patch.faces.end(),
                     [&](const PatchFace& face) {
                       return std::all_of(face.node.begin(), face.node.end(), known) && face.body >= 0 &&
                              face.area >= 0 && fits_in_patch(face.area);
                     }) &&
         std::all_of(patch.modes.begin(), patch.modes.end(),
                     [](const PatchMode& mode) {
                       return mode.stiffness >= 0 && mode.damping >= 0 && fits_in_patch(mode.stiffness) &&
                              fits_in_patch(mode.damping) && fits_in_patch(mode.force) && fits_in_patch(mode.z) &&
                              fits_in_patch(mode.rate);
                     }) &&
         std::all_of(patch.shapes.begin(), patch.shapes.end(), [](double x) { return fits_in_patch(x); });
}

}  // namespace tactor
