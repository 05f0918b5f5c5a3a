#include "nodes/scene/surface.hpp"

#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/orientation.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>

#include "framework/core/check.hpp"

namespace tactor {

namespace pmp = CGAL::Polygon_mesh_processing;

bool orient_polygons(std::vector<Point>& points, std::vector<std::vector<std::size_t>>& polygons) {
  return pmp::orient_polygon_soup(points, polygons);
}

Surface surface_of(const std::vector<Point>& points, const std::vector<std::vector<std::size_t>>& polygons) {
  TACTOR_DEMAND(pmp::is_polygon_soup_a_polygon_mesh(polygons));
  Surface surface;
  pmp::polygon_soup_to_polygon_mesh(points, polygons, surface);
  return surface;
}

PolygonSoup soup_of(const Surface& surface) {
  PolygonSoup soup;
  for (const auto v : surface.vertices()) {
    const Point& p = surface.point(v);
    soup.points.push_back({p.x(), p.y(), p.z()});
  }
  for (const Face f : surface.faces()) {
    const auto corners = corners_of(surface, f);
    soup.polygons.push_back({corners.begin(), corners.end()});
  }
  return soup;
}

bool is_outward_oriented(const Surface& surface) {
  return pmp::does_bound_a_volume(surface) && pmp::is_outward_oriented(surface);
}

void orient_outwards(Surface& surface) {
  pmp::orient_to_bound_a_volume(surface);
}

}  // namespace tactor
