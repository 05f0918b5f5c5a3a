#include "nodes/physics/cgal/surface_mesh.hpp"

#include <iterator>

#include <CGAL/Polygon_mesh_processing/self_intersections.h>

namespace tactor {

namespace pmp = CGAL::Polygon_mesh_processing;

std::vector<std::pair<Face, Face>> self_intersections(const SurfaceMesh& surface, unsigned most) {
  std::vector<std::pair<Face, Face>> pairs;
  pmp::self_intersections(surface, std::back_inserter(pairs), CGAL::parameters::maximum_number(most));
  return pairs;
}

}  // namespace tactor
