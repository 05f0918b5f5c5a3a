// Small closed meshes for tests.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <numbers>

#include "framework/core/temporary_folder.hpp"
#include "nodes/physics/mesh/mesh.hpp"

namespace tactor::test {

/// A box with edges a (m), centred at `center`.
inline TriangleMesh box(const Vec3& a, const Vec3& center = {}) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.push_back(center + Vec3{(i & 1) != 0 ? a.x / 2 : -a.x / 2, (i & 2) != 0 ? a.y / 2 : -a.y / 2,
                                          (i & 4) != 0 ? a.z / 2 : -a.z / 2});
  }
  const int quads[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& q : quads) {
    mesh.faces.push_back({q[0], q[1], q[2]});
    mesh.faces.push_back({q[0], q[2], q[3]});
  }
  return mesh;
}

/// An icosphere of radius r (m) about the origin: 20 * 4^levels faces, vertices on the sphere.
inline TriangleMesh icosphere(double r, int levels) {
  const double g = std::numbers::phi;
  TriangleMesh mesh;
  mesh.vertices = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                   {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  mesh.faces = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<int, int>, int> midpoints;
    const auto midpoint = [&](int a, int b) {
      const auto [entry, added] = midpoints.try_emplace(std::minmax(a, b), static_cast<int>(mesh.vertices.size()));
      if (added) {
        const Vec3 m = mesh.vertices[static_cast<std::size_t>(a)] + mesh.vertices[static_cast<std::size_t>(b)];
        mesh.vertices.push_back(m / norm(m));
      }
      return entry->second;
    };
    for (Vec3& v : mesh.vertices) v = v / norm(v);
    std::vector<std::array<int, 3>> faces;
    for (const auto& f : mesh.faces) {
      const int a = midpoint(f[0], f[1]), b = midpoint(f[1], f[2]), c = midpoint(f[2], f[0]);
      faces.insert(faces.end(), {{f[0], a, c}, {f[1], b, a}, {f[2], c, b}, {a, b, c}});
    }
    mesh.faces = faces;
  }
  for (Vec3& v : mesh.vertices) v = v * (r / norm(v));
  return mesh;
}

/// Writes the mesh into a file of a folder that this process alone has, and returns its path.
inline std::filesystem::path write_off(const TriangleMesh& mesh, const std::string& name) {
  static const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / (name + ".off");
  std::ofstream out(path);
  out.precision(17);
  out << "OFF\n" << mesh.vertices.size() << ' ' << mesh.faces.size() << " 0\n";
  for (const Vec3& v : mesh.vertices) out << v.x << ' ' << v.y << ' ' << v.z << '\n';
  for (const auto& f : mesh.faces) out << "3 " << f[0] << ' ' << f[1] << ' ' << f[2] << '\n';
  return path;
}

}  // namespace tactor::test
