#include "nodes/scene/surface.hpp"

#include <CGAL/Polygon_mesh_processing/repair.h>
#include <CGAL/Polygon_mesh_processing/repair_degeneracies.h>

namespace tactor {

namespace pmp = CGAL::Polygon_mesh_processing;

void remove_isolated_vertices(Surface& surface) {
  if (pmp::remove_isolated_vertices(surface) > 0) surface.collect_garbage();
}

void remove_flat_faces(Surface& surface) {
  pmp::remove_degenerate_faces(surface);
  surface.collect_garbage();
}

}  // namespace tactor
