// What the repairs of mesh_rework.hpp do to triangle meshes as lists: measure, part, join.
#pragma once

#include <array>
#include <cstddef>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "nodes/physics/mesh/mesh.hpp"
#include "nodes/physics/mesh/polygon_soup.hpp"
#include "nodes/physics/meshing/surface_rework.hpp"

namespace tactor {

/// Four digits.
std::string short_text(double v);
std::string place_text(const Vec3& p);

Corners corners_at(const TriangleMesh& mesh, std::size_t face);
std::vector<Corners> triangle_list(const TriangleMesh& mesh);
Vec3 middle_of(const Corners& t);
double area_of(const Corners& t);

/// Which body each face belongs to, from 0; their number.
std::pair<std::vector<std::size_t>, std::size_t> bodies_of(const TriangleMesh& mesh);

/// The faces for which `keep` is true, with the vertices that they need.
template <class Keep>
TriangleMesh part_of(const TriangleMesh& mesh, const Keep& keep) {
  TriangleMesh part;
  std::vector<int> place(mesh.vertices.size(), -1);
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    if (!keep(f)) continue;
    std::array<int, 3> face = mesh.faces[f];
    for (int& corner : face) {
      int& at = place[static_cast<std::size_t>(corner)];
      if (at < 0) {
        at = static_cast<int>(part.vertices.size());
        part.vertices.push_back(mesh.vertices[static_cast<std::size_t>(corner)]);
      }
      corner = at;
    }
    part.faces.push_back(face);
  }
  return part;
}

/// Adds the vertices and faces of `more`.
void append(TriangleMesh& mesh, const TriangleMesh& more);

/// For each edge in its direction, whether a face lies on it.
std::set<std::pair<int, int>> directed_edges(const TriangleMesh& mesh);
bool is_closed(const TriangleMesh& mesh);

PolygonSoup soup_of(const TriangleMesh& mesh);

}  // namespace tactor
