// The surface out of lists of vertices and faces, and back.
#include "nodes/physics/cgal/surface_mesh.hpp"

#include <cstdint>

#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>

#include "framework/core/check.hpp"

namespace tactor {

namespace pmp = CGAL::Polygon_mesh_processing;

SurfaceMesh surface_of(const std::vector<Point>& points, const std::vector<std::vector<std::size_t>>& polygons) {
  TACTOR_DEMAND(pmp::is_polygon_soup_a_polygon_mesh(polygons));
  SurfaceMesh surface;
  pmp::polygon_soup_to_polygon_mesh(points, polygons, surface);
  return surface;
}

SurfaceMesh surface_of(const TriangleMesh& mesh) {
  SurfaceMesh surface;
  for (const Vec3& v : mesh.vertices) surface.add_vertex(Point(v.x, v.y, v.z));
  const auto vertex = [](int i) { return SurfaceMesh::Vertex_index(static_cast<std::uint32_t>(i)); };
  for (const auto& f : mesh.faces) {
    if (surface.add_face(vertex(f[0]), vertex(f[1]), vertex(f[2])) == SurfaceMesh::null_face()) return {};
  }
  return surface;
}

TriangleMesh triangles_of(const SurfaceMesh& surface) {
  TriangleMesh mesh;
  for (const auto v : surface.vertices()) {
    const Point& p = surface.point(v);
    mesh.vertices.push_back({p.x(), p.y(), p.z()});
  }
  for (const Face f : surface.faces()) {
    const auto corners = corners_of(surface, f);
    mesh.faces.push_back({static_cast<int>(corners[0]), static_cast<int>(corners[1]), static_cast<int>(corners[2])});
  }
  return mesh;
}

PolygonSoup soup_of(const SurfaceMesh& surface) {
  TriangleMesh mesh = triangles_of(surface);
  PolygonSoup soup;
  soup.points = std::move(mesh.vertices);
  for (const auto& f : mesh.faces) soup.polygons.push_back({f.begin(), f.end()});
  return soup;
}

}  // namespace tactor
