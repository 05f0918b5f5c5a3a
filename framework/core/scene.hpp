// The scene of a graph as plain data: bodies, their shapes, motion, mass and material.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "framework/core/spatial.hpp"

namespace tactor {

/// How a body may move.
enum class Motion {
  fixed,        ///< it stays where it is
  translation,  ///< it moves and keeps its orientation: 3 degrees of freedom, no torque is computed
  rigid,        ///< 6 degrees of freedom
  deformable,   ///< it deforms as an elastic solid, see Deformable; it has no pose of its own beyond the start
};

/// Contact properties of a body's surface. Two bodies in contact: stiffnesses in series, damping of the softer,
/// friction as the geometric mean.
struct Material {
  double stiffness = 2000;   ///< N/m for one contact patch
  double damping = 2;        ///< N s/m for one contact patch
  double friction = 0.3;     ///< Coulomb coefficient
  double patch_area = 1e-4;  ///< m^2, the area of one contact patch when a mesh touches a mesh
  bool operator==(const Material&) const = default;
};

/// A closed triangle mesh read from a file.
struct MeshShape {
  std::filesystem::path file;  ///< an absolute path, checked to exist
  std::optional<double> scale =
      {};  ///< multiplies the file's coordinates to give metres; absent: 1, if the size is usual
  bool operator==(const MeshShape&) const = default;
};
/// A ball about the body's origin.
struct SphereShape {
  double radius = 0;  ///< m
  bool operator==(const SphereShape&) const = default;
};
/// All points within `radius` of the segment from z = -length/2 to z = length/2.
struct CapsuleShape {
  double radius = 0;  ///< m
  double length = 0;  ///< m, of the segment, without the caps
  bool operator==(const CapsuleShape&) const = default;
};
/// A cuboid about the body's origin, its edges along the axes.
struct BoxShape {
  Vec3 size;  ///< m, whole edges
  bool operator==(const BoxShape&) const = default;
};
/// The half-space z <= 0 of the body's frame: its surface faces +z. Only a fixed body may be one.
struct PlaneShape {
  bool operator==(const PlaneShape&) const = default;
};
using Shape = std::variant<MeshShape, SphereShape, CapsuleShape, BoxShape, PlaneShape>;

/// All points of a box whose edges are along the axes.
struct BoxRegion {
  Vec3 low, high;  ///< m
  bool operator==(const BoxRegion&) const = default;
};
/// All points on a plane and behind it: dot(n, x - p) <= 0.
struct HalfSpaceRegion {
  Vec3 p;  ///< m
  Vec3 n;  ///< of any length above zero
  bool operator==(const HalfSpaceRegion&) const = default;
};
/// The faces that a volume mesh names.
struct NamedFaces {
  std::string name;
  bool operator==(const NamedFaces&) const = default;
};
/// Which points of a deformable body do not move, in the frame of the body.
using FixedRegion = std::variant<BoxRegion, HalfSpaceRegion, NamedFaces>;

/// A ball of another stiffness inside a deformable body.
struct Inclusion {
  Vec3 p;             ///< m, its centre in the frame of the body
  double radius = 0;  ///< m
  double young = 0;   ///< Pa
  bool operator==(const Inclusion&) const = default;
};

/// An elastic solid of uniform material, except its inclusions.
struct Deformable {
  double young = 20e3;     ///< Pa
  double poisson = 0.45;   ///< below 0.5
  double density = 1000;   ///< kg/m^3
  double damping = 0.005;  ///< s, stress per rate of strain over the stiffness (Rayleigh's beta)
  double drag = 0;         ///< 1/s, force per velocity over the mass (Rayleigh's alpha)
  int tetrahedra = 3000;   ///< approximate number; not used if `cell_size` is given or a file holds tetrahedra
  double cell_size = 0;    ///< m, length of edges; 0: by `tetrahedra`
  std::vector<FixedRegion> fixed;
  std::vector<Inclusion> inclusions;
  bool operator==(const Deformable&) const = default;
};

/// A body.
struct Body {
  std::string name;
  Shape shape;
  Pose X_WB;  ///< the body in the world at the start
  Motion motion = Motion::fixed;
  double mass = 0.1;            ///< kg, of a body that moves as a whole
  std::optional<Vec3> inertia;  ///< kg m^2, principal, in the body frame; from the shape when absent
  Material material;
  Deformable deformable;  ///< of a deformable body

  /// True if it moves as a whole.
  [[nodiscard]] bool moves() const { return motion == Motion::translation || motion == Motion::rigid; }
  [[nodiscard]] const MeshShape* mesh() const { return std::get_if<MeshShape>(&shape); }
};

/// The most moving bodies of a scene.
inline constexpr std::size_t max_moving_bodies = 8;

/// The view of a scene.
struct Camera {
  Vec3 from_W{1, 0.5, 0.42};  ///< from the middle of the scene towards the camera, of any length above zero
  Vec3 up_W{0, 0, 1};         ///< the upward direction in the picture; not along `from_W`
  bool operator==(const Camera&) const = default;
};

/// The scene in which a graph's nodes act.
struct Scene {
  Vec3 gravity_W{0, 0, -9.81};  ///< m/s^2
  Camera camera;                ///< for drawing; nothing else depends on it
  std::vector<Body> bodies;
  std::string tool_name;  ///< the moving body that hangs on the device; empty: the first one that moves

  /// Indices of the bodies that move as a whole, the tool first, the others in their order.
  [[nodiscard]] std::vector<std::size_t> moving() const {
    std::vector<std::size_t> indices;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      if (!bodies[i].moves()) continue;
      indices.insert(bodies[i].name == tool_name ? indices.begin() : indices.end(), i);
    }
    return indices;
  }
  /// Indices of the bodies that deform, in their order.
  [[nodiscard]] std::vector<std::size_t> deformable() const {
    std::vector<std::size_t> indices;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      if (bodies[i].motion == Motion::deformable) indices.push_back(i);
    }
    return indices;
  }
  /// The moving body that hangs on the device, or null if nothing moves.
  [[nodiscard]] const Body* tool() const {
    const std::vector<std::size_t> indices = moving();
    return indices.empty() ? nullptr : &bodies[indices.front()];
  }
  /// True if the tool can rotate, so that torque has a meaning.
  [[nodiscard]] bool rotates() const { return tool() != nullptr && tool()->motion == Motion::rigid; }
};

}  // namespace tactor
