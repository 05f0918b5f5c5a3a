#include "nodes/collision/mesh_check.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/orientation.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Surface_mesh.h>

#include "framework/core/check.hpp"

namespace tactor {

void check_solid(const TriangleMesh& mesh, const std::string& name) {
  namespace pmp = CGAL::Polygon_mesh_processing;
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

  std::vector<Kernel::Point_3> points;
  for (const Vec3& v : mesh.vertices) points.emplace_back(v.x, v.y, v.z);
  std::vector<std::vector<std::size_t>> polygons;
  std::size_t index = 0;
  for (const auto& f : mesh.faces) {
    polygons.push_back(
        {static_cast<std::size_t>(f[0]), static_cast<std::size_t>(f[1]), static_cast<std::size_t>(f[2])});
    if (CGAL::collinear(points[polygons.back()[0]], points[polygons.back()[1]], points[polygons.back()[2]])) {
      throw InputError(name + ": face " + std::to_string(index) +
                       " has no area; remove degenerate faces and repeated vertices");
    }
    ++index;
  }
  if (!pmp::is_polygon_soup_a_polygon_mesh(polygons)) {
    throw InputError(name +
                     ": the faces make no manifold surface (an edge with more than two faces, or neighbours that turn "
                     "different ways); repair the mesh in a modeller");
  }
  CGAL::Surface_mesh<Kernel::Point_3> surface;
  pmp::polygon_soup_to_polygon_mesh(points, polygons, surface);
  if (!CGAL::is_closed(surface)) {
    throw InputError(name + ": the surface has a hole; contact needs a closed mesh, fill the hole in a modeller");
  }
  if (pmp::does_self_intersect(surface)) {
    throw InputError(name + ": the surface cuts itself; repair the mesh in a modeller");
  }
  if (!pmp::does_bound_a_volume(surface) || !pmp::is_outward_oriented(surface)) {
    throw InputError(name + ": the faces look inwards; they must be counter-clockwise as seen from outside, flip them");
  }
}

}  // namespace tactor
