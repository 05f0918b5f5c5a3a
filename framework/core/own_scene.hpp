// A scene that a node brings itself, such as the model of another engine, as plain data.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "framework/core/scene.hpp"

namespace tactor {

/// All points within `radius` of the z axis, from z = -length/2 to z = length/2.
struct CylinderShape {
  double radius = 0;  ///< m
  double length = 0;  ///< m
};
/// An ellipsoid about the origin, its axes along x, y and z.
struct EllipsoidShape {
  Vec3 radii;  ///< m
};
/// Triangles that need not be closed. Faces list vertex indices counter-clockwise as seen from outside.
struct Triangles {
  std::vector<Vec3> vertices;  ///< m
  std::vector<std::array<int, 3>> faces;
};
/// Shapes that share their triangles are sent to a page once.
struct TrianglesShape {
  std::shared_ptr<const Triangles> triangles;  ///< never null
};

/// A shape for pictures; nothing else depends on it.
struct OwnShape {
  std::string name;  ///< no body of the graph's scene and no other shape has it
  std::variant<SphereShape, CapsuleShape, BoxShape, PlaneShape, CylinderShape, EllipsoidShape, TrianglesShape> form;
  std::optional<std::size_t> body;  ///< that it moves with, an index into OwnScene::bodies; none: it stays
  Pose X_BS;                        ///< m, in the frame of its body; of a shape that stays in W
};

/// The form as a scene has it; none where a scene has no such shape.
inline std::optional<Shape> scene_shape(const OwnShape& shape) {
  if (const auto* sphere = std::get_if<SphereShape>(&shape.form)) return *sphere;
  if (const auto* capsule = std::get_if<CapsuleShape>(&shape.form)) return *capsule;
  if (const auto* box = std::get_if<BoxShape>(&shape.form)) return *box;
  if (const auto* plane = std::get_if<PlaneShape>(&shape.form)) return *plane;
  return std::nullopt;
}

/// A body that moves.
struct OwnBody {
  std::string name;  ///< a moving body of the graph's scene that has it is this one, and is not drawn beside it
  Pose X_WB;         ///< m, at the start
};

/// The scene of a node. The poses of its bodies come in its messages BodyPoses, in the same order.
struct OwnScene {
  std::vector<OwnBody> bodies;  ///< the tool first, which is also the tool of the graph's scene
  std::vector<OwnShape> shapes;
};

/// The tool of such a scene, for a graph whose own scene has none.
struct OwnTool {
  Body body;       ///< with mass, motion and, where it turns, inertia
  Vec3 gravity_W;  ///< m/s^2
};

}  // namespace tactor
