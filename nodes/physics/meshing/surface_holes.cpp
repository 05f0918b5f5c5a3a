#include <algorithm>
#include <iterator>
#include <limits>

#include <CGAL/Polygon_mesh_processing/border.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>

#include "nodes/physics/cgal/surface_mesh.hpp"
#include "nodes/physics/mesh/bounds.hpp"
#include "nodes/physics/meshing/surface_rework.hpp"

namespace tactor {

namespace pmp = CGAL::Polygon_mesh_processing;

namespace {

using Halfedge = SurfaceMesh::Halfedge_index;

/// The corners of a rim, in its order.
std::vector<Vec3> rim_of(const SurfaceMesh& surface, Halfedge begin) {
  std::vector<Vec3> rim;
  Halfedge h = begin;
  do {
    const Point& p = surface.point(surface.target(h));
    rim.push_back({p.x(), p.y(), p.z()});
    h = surface.next(h);
  } while (h != begin);
  return rim;
}

double distance_from_rim(const Vec3& p, const std::vector<Vec3>& rim) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < rim.size(); ++i) {
    const Vec3 &a = rim[i], way = rim[(i + 1) % rim.size()] - a;
    const double square = dot(way, way);
    const double t = square > 0 ? std::clamp(dot(p - a, way) / square, 0.0, 1.0) : 0;
    nearest = std::min(nearest, norm(p - (a + t * way)));
  }
  return nearest;
}

/// By points of a grid on each triangle.
double width_of(const SurfaceMesh& surface, const std::vector<Face>& patch, const std::vector<Vec3>& rim) {
  // A few triangles are large beside the hole; many were refined.
  const int steps = patch.size() > 50 ? 2 : 12;
  double farthest = 0;
  for (const Face f : patch) {
    std::array<Vec3, 3> corner;
    std::size_t k = 0;
    for (const auto v : corners_of(surface, f)) {
      const Point& p = surface.point(v);
      corner[k++] = {p.x(), p.y(), p.z()};
    }
    for (int i = 0; i <= steps; ++i) {
      for (int j = 0; i + j <= steps; ++j) {
        const double u = static_cast<double>(i) / steps, v = static_cast<double>(j) / steps;
        farthest = std::max(farthest, distance_from_rim((1 - u - v) * corner[0] + u * corner[1] + v * corner[2], rim));
      }
    }
  }
  return 2 * farthest;
}

/// Fills one hole; no faces where CGAL finds no triangles for it.
std::vector<Face> fill_hole(SurfaceMesh& surface, Halfedge border, std::size_t edges) {
  std::vector<Face> patch;
  std::vector<SurfaceMesh::Vertex_index> vertices;
  if (edges > 8) {
    pmp::triangulate_and_refine_hole(surface, border, std::back_inserter(patch), std::back_inserter(vertices));
  } else {
    pmp::triangulate_hole(surface, border, std::back_inserter(patch));
  }
  constexpr std::size_t most_searched = 200;  // the search over all triangulations takes their cube
  if (patch.empty() && edges <= most_searched) {
    pmp::triangulate_hole(surface, border, std::back_inserter(patch),
                          CGAL::parameters::use_delaunay_triangulation(false));
  }
  return patch;
}

}  // namespace

FilledHoles fill_holes(const TriangleMesh& mesh) {
  FilledHoles result;
  SurfaceMesh surface = surface_of(mesh);
  std::vector<Halfedge> borders;
  pmp::extract_boundary_cycles(surface, std::back_inserter(borders));
  const std::size_t before = surface.number_of_faces();
  for (const Halfedge border : borders) {
    const std::vector<Vec3> rim = rim_of(surface, border);
    Hole hole;
    hole.edges = rim.size();
    Bounds bounds;
    for (const Vec3& p : rim) bounds.add(p);
    hole.place = bounds.middle();
    const std::vector<Face> patch = fill_hole(surface, border, hole.edges);
    hole.width = width_of(surface, patch, rim);
    (patch.empty() ? result.failed : result.filled).push_back(hole);
  }
  result.mesh = triangles_of(surface);
  for (std::size_t f = before; f < result.mesh.faces.size(); ++f) {
    Corners corners;
    for (std::size_t k = 0; k < 3; ++k) {
      corners[k] = result.mesh.vertices[static_cast<std::size_t>(result.mesh.faces[f][k])];
    }
    result.patches.push_back(corners);
  }
  return result;
}

}  // namespace tactor
