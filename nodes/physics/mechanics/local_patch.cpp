#include "nodes/physics/mechanics/local_patch.hpp"

#include <algorithm>
#include <cmath>

namespace tactor {

template <>
const MessageType& message_type<PatchNode>() {
  static const MessageType type = Describe<PatchNode>("PatchNode", "W")
                                      .field("p_W", "m", &PatchNode::p_W)
                                      .field("v_W", "m/s", &PatchNode::v_W)
                                      .field("fixed", "1", &PatchNode::fixed)
                                      .type();
  return type;
}

template <>
const MessageType& message_type<PatchFace>() {
  static const MessageType type = Describe<PatchFace>("PatchFace")
                                      .field("node", "1", &PatchFace::node)
                                      .field("body", "1", &PatchFace::body)
                                      .field("area", "m^2", &PatchFace::area)
                                      .type();
  return type;
}

template <>
const MessageType& message_type<PatchMode>() {
  static const MessageType type = Describe<PatchMode>("PatchMode")
                                      .field("stiffness", "1/s^2", &PatchMode::stiffness)
                                      .field("damping", "1/s", &PatchMode::damping)
                                      .field("force", "kg^0.5 m/s^2", &PatchMode::force)
                                      .field("z", "kg^0.5 m", &PatchMode::z)
                                      .field("rate", "kg^0.5 m/s", &PatchMode::rate)
                                      .type();
  return type;
}

template <>
const MessageType& message_type<LocalPatch>() {
  static const MessageType type = Describe<LocalPatch>("LocalPatch", "W")
                                      .field("nodes", &LocalPatch::nodes)
                                      .field("faces", &LocalPatch::faces)
                                      .field("modes", &LocalPatch::modes)
                                      .field("shapes", "kg^-0.5", &LocalPatch::shapes)
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
