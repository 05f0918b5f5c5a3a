// Where the bodies of a node's own scene are, for those who show them.
#pragma once

#include "framework/core/describe.hpp"
#include "framework/core/shared_array.hpp"
#include "framework/core/spatial.hpp"

namespace tactor {

/// The pose of a body that is shown.
struct ShownPose {
  std::array<float, 3> p_WB{};  ///< m
  std::array<float, 4> R_WB{};  ///< unit quaternion w, x, y, z
};

/// The poses of all bodies that move, however many.
struct BodyPoses {
  SharedArray<ShownPose> poses;
};

inline ShownPose shown_pose(const Pose& X) {
  const auto f = [](double x) { return static_cast<float>(x); };
  return {{f(X.p.x), f(X.p.y), f(X.p.z)}, {f(X.R.w), f(X.R.x), f(X.R.y), f(X.R.z)}};
}

inline Pose pose_of(const ShownPose& shown) {
  const auto& [x, y, z] = shown.p_WB;
  const auto& [w, i, j, k] = shown.R_WB;
  return {{x, y, z}, {w, i, j, k}};
}

template <>
inline const MessageType& message_type<ShownPose>() {
  static const MessageType type =
      Describe<ShownPose>("ShownPose", "W", "Pose of a body, in single precision: for display alone.")
          .field("p_WB", "m", &ShownPose::p_WB, "Position of the origin of the body B, measured from the origin of W.")
          .field("R_WB", "1", &ShownPose::R_WB, "Rotation from B to W as a unit quaternion w, x, y, z.")
          .type();
  return type;
}

template <>
inline const MessageType& message_type<BodyPoses>() {
  static const MessageType type =
      Describe<BodyPoses>("BodyPoses", "W",
                          "The poses of all moving bodies of a node's own scene. Stamped valid for the device sample "
                          "that the step of physics was computed against.")
          .field("poses", &BodyPoses::poses,
                 "One for each body, the tool first, in the order in which the node's scene has them.")
          .type();
  return type;
}

}  // namespace tactor
