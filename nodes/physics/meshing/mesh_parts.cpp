#include "nodes/physics/meshing/mesh_parts.hpp"

#include <algorithm>
#include <cstdio>
#include <map>
#include <numeric>

namespace tactor {

std::string short_text(double v) {
  std::array<char, 40> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "%.4g", v);
  return buffer.data();
}
std::string place_text(const Vec3& p) {
  return "(" + short_text(p.x) + ", " + short_text(p.y) + ", " + short_text(p.z) + ")";
}

Corners corners_at(const TriangleMesh& mesh, std::size_t face) {
  const auto& f = mesh.faces[face];
  const auto at = [&](std::size_t i) { return mesh.vertices[static_cast<std::size_t>(f[i])]; };
  return {at(0), at(1), at(2)};
}
std::vector<Corners> triangle_list(const TriangleMesh& mesh) {
  std::vector<Corners> list;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) list.push_back(corners_at(mesh, f));
  return list;
}
Vec3 middle_of(const Corners& t) {
  return (t[0] + t[1] + t[2]) / 3;
}
double area_of(const Corners& t) {
  return 0.5 * norm(cross(t[1] - t[0], t[2] - t[0]));
}

std::pair<std::vector<std::size_t>, std::size_t> bodies_of(const TriangleMesh& mesh) {
  std::vector<std::size_t> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  const auto root = [&](std::size_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (const auto& f : mesh.faces) {
    for (std::size_t k = 1; k < 3; ++k)
      parent[root(static_cast<std::size_t>(f[k]))] = root(static_cast<std::size_t>(f[0]));
  }
  std::map<std::size_t, std::size_t> number;
  std::vector<std::size_t> body;
  for (const auto& f : mesh.faces) {
    body.push_back(number.emplace(root(static_cast<std::size_t>(f[0])), number.size()).first->second);
  }
  return {std::move(body), number.size()};
}

void append(TriangleMesh& mesh, const TriangleMesh& more) {
  const auto first = static_cast<int>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), more.vertices.begin(), more.vertices.end());
  for (const auto& f : more.faces) mesh.faces.push_back({f[0] + first, f[1] + first, f[2] + first});
}

std::set<std::pair<int, int>> directed_edges(const TriangleMesh& mesh) {
  std::set<std::pair<int, int>> edges;
  for (const auto& f : mesh.faces) {
    for (std::size_t k = 0; k < 3; ++k) edges.emplace(f[k], f[(k + 1) % 3]);
  }
  return edges;
}
bool is_closed(const TriangleMesh& mesh) {
  const auto edges = directed_edges(mesh);
  return std::all_of(edges.begin(), edges.end(), [&](const auto& e) { return edges.contains({e.second, e.first}); });
}

PolygonSoup soup_of(const TriangleMesh& mesh) {
  PolygonSoup soup;
  soup.points = mesh.vertices;
  for (const auto& f : mesh.faces) {
    soup.polygons.push_back(
        {static_cast<std::size_t>(f[0]), static_cast<std::size_t>(f[1]), static_cast<std::size_t>(f[2])});
  }
  return soup;
}

}  // namespace tactor
