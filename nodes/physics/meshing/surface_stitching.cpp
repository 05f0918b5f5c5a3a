#include <CGAL/Polygon_mesh_processing/repair.h>
#include <CGAL/Polygon_mesh_processing/stitch_borders.h>

#include "nodes/physics/cgal/surface_mesh.hpp"
#include "nodes/physics/meshing/surface_rework.hpp"

namespace tactor {

namespace pmp = CGAL::Polygon_mesh_processing;

TriangleMesh stitched(const std::vector<Point>& points, const std::vector<std::vector<std::size_t>>& triangles) {
  SurfaceMesh surface = surface_of(points, triangles);
  pmp::stitch_boundary_cycles(surface);
  pmp::stitch_borders(surface);
  pmp::duplicate_non_manifold_vertices(surface);
  surface.collect_garbage();
  return triangles_of(surface);
}

}  // namespace tactor
