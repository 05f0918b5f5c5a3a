// How well samples cover a surface, found by brute force.
#pragma once

#include <algorithm>
#include <limits>
#include <random>
#include <vector>

#include "nodes/physics/geometry/triangle.hpp"
#include "nodes/physics/mesh/bounds.hpp"
#include "nodes/physics/mesh/surface_samples.hpp"

namespace tactor::test {

inline std::array<Vec3, 3> corners(const TriangleMesh& mesh, std::size_t face) {
  const auto at = [&](int i) { return mesh.vertices[static_cast<std::size_t>(i)]; };
  return {at(mesh.faces[face][0]), at(mesh.faces[face][1]), at(mesh.faces[face][2])};
}

inline Vec3 unit_normal(const TriangleMesh& mesh, std::size_t face) {
  const Vec3 n = doubled_area_normal(mesh, mesh.faces[face]);
  return n / norm(n);
}

/// The largest distance, m, of `count` random points of the surface from the nearest sample of their sheet: one on a
/// face whose normal is within 60 degrees of that at the point. Half of the points are spread by area, half by face, so
/// that slivers have some. Infinite where a point has no such sample.
inline double covering_distance(const TriangleMesh& mesh, const std::vector<SurfaceSample>& samples, int count) {
  std::vector<Vec3> normals;
  std::vector<double> areas;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    normals.push_back(unit_normal(mesh, f));
    areas.push_back(norm(doubled_area_normal(mesh, mesh.faces[f])));
  }
  // The faces that each sample lies on.
  std::vector<std::vector<std::size_t>> own(samples.size());
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const auto triangle = corners(mesh, f);
    Bounds box;
    for (const Vec3& v : triangle) box.add(v);
    for (std::size_t s = 0; s < samples.size(); ++s) {
      const Vec3& p = samples[s].p;
      const Vec3 below = box.low - p, above = p - box.high;
      if (std::max({below.x, below.y, below.z, above.x, above.y, above.z}) > 1e-9) continue;
      if (norm(nearest_on(triangle, p).p - p) < 1e-9) own[s].push_back(f);
    }
  }
  std::mt19937 random(7);
  std::discrete_distribution<std::size_t> by_area(areas.begin(), areas.end());
  std::uniform_int_distribution<std::size_t> by_face(0, mesh.faces.size() - 1);
  std::uniform_real_distribution<double> uniform;
  double farthest = 0;
  for (int i = 0; i < count; ++i) {
    const std::size_t face = i % 2 == 0 ? by_area(random) : by_face(random);
    const auto [a, b, c] = corners(mesh, face);
    double u = uniform(random), v = uniform(random);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const Vec3 p = a + u * (b - a) + v * (c - a);
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t s = 0; s < samples.size(); ++s) {
      const double distance = norm(samples[s].p - p);
      if (distance >= nearest) continue;
      if (std::any_of(own[s].begin(), own[s].end(),
                      [&](std::size_t f) { return dot(normals[f], normals[face]) >= 0.5; })) {
        nearest = distance;
      }
    }
    farthest = std::max(farthest, nearest);
  }
  return farthest;
}

inline double total_area(const std::vector<SurfaceSample>& samples) {
  double sum = 0;
  for (const SurfaceSample& s : samples) sum += s.area;
  return sum;
}

}  // namespace tactor::test
