// Round bodies as triangles.
#pragma once

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "nodes/physics/mesh/mesh.hpp"

namespace tactor {

/// Parts of a circle of these meshes.
inline constexpr int parts_of_circle = 64;

/// The surface that a line from one point of the z axis to another makes round that axis. `profile`: distance from the
/// axis and height in m, from below to above.
inline TriangleMesh turned_mesh(const std::vector<std::pair<double, double>>& profile) {
  TriangleMesh mesh;
  for (const auto& [distance, height] : profile) {
    for (int k = 0; k < parts_of_circle; ++k) {
      const double angle = 2 * std::numbers::pi * k / parts_of_circle;
      mesh.vertices.push_back({distance * std::cos(angle), distance * std::sin(angle), height});
    }
  }
  for (int ring = 0; ring + 1 < static_cast<int>(profile.size()); ++ring) {
    for (int k = 0; k < parts_of_circle; ++k) {
      const int a = ring * parts_of_circle + k, b = ring * parts_of_circle + (k + 1) % parts_of_circle;
      mesh.faces.push_back({a, b, b + parts_of_circle});
      mesh.faces.push_back({a, b + parts_of_circle, a + parts_of_circle});
    }
  }
  return mesh;
}

/// A capsule along z, `length` without its caps; a sphere where that is 0. In m.
inline TriangleMesh capsule_mesh(double radius, double length) {
  std::vector<std::pair<double, double>> profile;
  for (int i = 0; i <= parts_of_circle / 2; ++i) {
    const double angle = std::numbers::pi * (i / (parts_of_circle / 2.0) - 0.5);
    profile.emplace_back(radius * std::cos(angle), radius * std::sin(angle) + (angle < 0 ? -0.5 : 0.5) * length);
  }
  return turned_mesh(profile);
}

/// A cylinder along z, its middle at the origin. In m.
inline TriangleMesh cylinder_mesh(double radius, double length) {
  return turned_mesh({{0, -0.5 * length}, {radius, -0.5 * length}, {radius, 0.5 * length}, {0, 0.5 * length}});
}

/// An ellipsoid, its axes along x, y and z. In m.
inline TriangleMesh ellipsoid_mesh(const Vec3& radii) {
  TriangleMesh mesh = capsule_mesh(1, 0);
  for (Vec3& v : mesh.vertices) v = {radii.x * v.x, radii.y * v.y, radii.z * v.z};
  return mesh;
}

}  // namespace tactor
