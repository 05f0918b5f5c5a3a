// The scene of a graph as plain data: bodies, their shapes, motion, mass and material.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "framework/core/spatial.hpp"

namespace tactor {

/// How a body may move.
enum class Motion {
  fixed,        ///< it stays where it is
  translation,  ///< it moves and keeps its orientation: 3 degrees of freedom, no torque is computed
  rigid,        ///< 6 degrees of freedom
};

/// Contact properties of a body's surface. Two bodies in contact: stiffnesses in series, damping of the softer,
/// friction as the geometric mean.
struct Material {
  double stiffness = 2000;   ///< N/m for one contact patch
  double damping = 2;        ///< N s/m for one contact patch
  double friction = 0.3;     ///< Coulomb coefficient
  double patch_area = 1e-4;  ///< m^2, the area one contact patch stands for where a mesh touches a mesh
};

/// A body. Exactly one of `mesh` and `sphere_radius` is set.
struct Body {
  std::string name;
  std::optional<std::filesystem::path> mesh;  ///< an absolute path, checked to exist
  std::optional<double> sphere_radius;        ///< m
  std::optional<double> scale;  ///< multiplies the mesh's coordinates to give metres; absent: 1, if the size is usual
  Pose X_WB;                    ///< the body in the world at the start
  Motion motion = Motion::fixed;
  double mass = 0.1;            ///< kg, of a moving body
  std::optional<Vec3> inertia;  ///< kg m^2, principal, in the body frame; from the mesh when absent
  Material material;
};

/// What a graph's nodes act in.
struct Scene {
  Vec3 gravity_W{0, 0, -9.81};  ///< m/s^2
  std::vector<Body> bodies;

  /// The moving body, or null where there is none.
  [[nodiscard]] const Body* tool() const {
    for (const Body& body : bodies) {
      if (body.motion != Motion::fixed) return &body;
    }
    return nullptr;
  }
  /// True where the tool can rotate, so that torque has a meaning.
  [[nodiscard]] bool rotates() const { return tool() != nullptr && tool()->motion == Motion::rigid; }
};

}  // namespace tactor
