#include "nodes/scene/surface.hpp"

#include <CGAL/Polygon_mesh_processing/repair_degeneracies.h>

namespace tactor {

namespace pmp = CGAL::Polygon_mesh_processing;

void remove_flat_faces(Surface& surface) {
  pmp::remove_degenerate_faces(surface);
  surface.collect_garbage();
}

}  // namespace tactor
