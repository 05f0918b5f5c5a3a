#include <CGAL/Polygon_2_algorithms.h>
#include <CGAL/Polygon_mesh_processing/compute_normal.h>
#include <CGAL/Projection_traits_3.h>

#include "nodes/physics/cgal/surface_mesh.hpp"

namespace tactor {

std::optional<Face> tangled_face(const SurfaceMesh& surface) {
  // Cutting a small one costs little whatever its shape.
  constexpr std::size_t small = 200;
  std::vector<Point> corners;
  for (const Face f : surface.faces()) {
    if (surface.degree(f) <= small) continue;
    corners.clear();
    for (const auto v : surface.vertices_around_face(surface.halfedge(f))) corners.push_back(surface.point(v));
    const Kernel::Vector_3 normal = CGAL::Polygon_mesh_processing::compute_face_normal(f, surface);
    if (normal == CGAL::NULL_VECTOR) return f;
    if (!CGAL::is_simple_2(corners.begin(), corners.end(), CGAL::Projection_traits_3<Kernel>(normal))) return f;
  }
  return std::nullopt;
}

}  // namespace tactor
