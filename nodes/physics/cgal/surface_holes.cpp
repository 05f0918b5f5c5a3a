#include <iterator>

#include <CGAL/Polygon_mesh_processing/border.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>

#include "nodes/physics/cgal/surface_mesh.hpp"
#include "nodes/physics/cgal/surface_rework.hpp"
#include "nodes/physics/mesh/bounds.hpp"

namespace tactor {

namespace pmp = CGAL::Polygon_mesh_processing;

namespace {

using Halfedge = SurfaceMesh::Halfedge_index;

Hole hole_of(const SurfaceMesh& surface, Halfedge begin) {
  Bounds bounds;
  Hole hole;
  Halfedge h = begin;
  do {
    const Point& p = surface.point(surface.target(h));
    bounds.add({p.x(), p.y(), p.z()});
    ++hole.edges;
    h = surface.next(h);
  } while (h != begin);
  hole.place = bounds.middle();
  hole.size = norm(bounds.size());
  return hole;
}

/// Fills one hole; false where CGAL finds no triangles for it.
bool fill_hole(SurfaceMesh& surface, Halfedge border, std::size_t edges) {
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
  return !patch.empty();
}

}  // namespace

FilledHoles fill_holes(const TriangleMesh& mesh, double most) {
  FilledHoles result;
  SurfaceMesh surface = surface_of(mesh);
  std::vector<Halfedge> borders;
  pmp::extract_boundary_cycles(surface, std::back_inserter(borders));
  const std::size_t before = surface.number_of_faces();
  for (const Halfedge border : borders) {
    const Hole hole = hole_of(surface, border);
    if (hole.size > most) {
      result.too_large.push_back(hole);
    } else if (fill_hole(surface, border, hole.edges)) {
      result.filled.push_back(hole);
    } else {
      result.failed.push_back(hole);
    }
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
