#include "nodes/physics/cgal/surface_mesh.hpp"

#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/orientation.h>

namespace tactor {

namespace pmp = CGAL::Polygon_mesh_processing;

bool orient_polygons(std::vector<Point>& points, std::vector<std::vector<std::size_t>>& polygons) {
  return pmp::orient_polygon_soup(points, polygons);
}

bool is_outward_oriented(const SurfaceMesh& surface) {
  return pmp::does_bound_a_volume(surface) && pmp::is_outward_oriented(surface);
}

void orient_outwards(SurfaceMesh& surface) {
  pmp::orient_to_bound_a_volume(surface);
}

}  // namespace tactor
