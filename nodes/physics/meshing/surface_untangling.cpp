#include <CGAL/Polygon_mesh_processing/repair_self_intersections.h>

#include "nodes/physics/cgal/surface_mesh.hpp"
#include "nodes/physics/meshing/surface_rework.hpp"

namespace tactor {

namespace pmp = CGAL::Polygon_mesh_processing;

TriangleMesh untangled(const TriangleMesh& mesh) {
  SurfaceMesh surface = surface_of(mesh);
  pmp::experimental::remove_self_intersections(surface);
  // Where it gave up it leaves holes.
  surface.collect_garbage();
  remove_isolated_vertices(surface);
  return triangles_of(surface);
}

}  // namespace tactor
