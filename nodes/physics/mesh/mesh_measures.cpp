#include "nodes/physics/mesh/mesh_measures.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <set>
#include <vector>

#include "nodes/physics/mesh/soup_topology.hpp"

namespace tactor {

MeshMeasures measures_of(const PolygonSoup& soup) {
  MeshMeasures measures;
  measures.vertices = soup.points.size();
  measures.faces = soup.polygons.size();
  MeshReport ignored;
  const NumberedSoup tidied = tidy(soup, ignored);
  for (const Vec3& p : tidied.points) measures.bounds.add(p);
  const EdgeFaults faults = find_edge_faults(tidied, std::vector<bool>(tidied.polygons.size(), false));
  measures.open_edges = faults.borders;
  measures.shared_edges = faults.branches;
  std::vector<std::size_t> parent(tidied.points.size());
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  const auto root = [&](std::size_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  measures.shortest_edge = tidied.polygons.empty() ? 0 : std::numeric_limits<double>::infinity();
  for (const auto& polygon : tidied.polygons) {
    Vec3 doubled;
    for (std::size_t k = 0; k < polygon.size(); ++k) {
      const Vec3 &a = tidied.points[polygon[k]], &b = tidied.points[polygon[(k + 1) % polygon.size()]];
      measures.shortest_edge = std::min(measures.shortest_edge, norm(b - a));
      measures.longest_edge = std::max(measures.longest_edge, norm(b - a));
      doubled += cross(a - tidied.points[polygon[0]], b - tidied.points[polygon[0]]);
      parent[root(polygon[k])] = root(polygon[0]);
    }
    measures.area += 0.5 * norm(doubled);
  }
  std::set<std::size_t> roots;
  for (const auto& polygon : tidied.polygons) roots.insert(root(polygon[0]));
  measures.pieces = roots.size();
  return measures;
}

}  // namespace tactor
