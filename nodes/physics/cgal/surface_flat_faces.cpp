#include "nodes/physics/cgal/surface_mesh.hpp"

#include <CGAL/Polygon_mesh_processing/repair.h>
#include <CGAL/Polygon_mesh_processing/repair_degeneracies.h>

namespace tactor {

namespace pmp = CGAL::Polygon_mesh_processing;

void remove_isolated_vertices(SurfaceMesh& surface) {
  if (pmp::remove_isolated_vertices(surface) > 0) surface.collect_garbage();
}

void remove_flat_faces(SurfaceMesh& surface) {
  pmp::remove_degenerate_faces(surface);
  surface.collect_garbage();
}

}  // namespace tactor
