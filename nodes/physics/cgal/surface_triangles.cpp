#include "nodes/physics/cgal/surface_mesh.hpp"

#include <CGAL/Polygon_mesh_processing/triangulate_faces.h>

#include "framework/core/check.hpp"

namespace tactor {

namespace pmp = CGAL::Polygon_mesh_processing;

namespace {

/// Charges the work before it is done.
void charge(const SurfaceMesh& surface, FaceNumbers numbers, const std::string& file, ReadBudget& budget) {
  std::uint64_t work = 0;
  Face widest = SurfaceMesh::null_face();
  for (const Face f : surface.faces()) {
    const std::uint64_t corners = surface.degree(f);
    if (corners > 3) work += corners * corners;
    if (widest == SurfaceMesh::null_face() || corners > surface.degree(widest)) widest = f;
  }
  if (budget.holds(work)) return;
  throw InputError(file + ": cutting the faces into triangles takes too long: face " + std::to_string(numbers[widest]) +
                   " (counted from 0) has " + std::to_string(surface.degree(widest)) +
                   " corners; cut it in a modeller");
}

/// Carries the number of a polygon over to the triangles that it is cut into.
struct KeepNumber : pmp::Triangulate_faces::Default_visitor<SurfaceMesh> {
  KeepNumber(FaceNumbers all, std::size_t* of_polygon) : numbers(all), current(of_polygon) {}
  FaceNumbers numbers;
  std::size_t* current;
  void before_subface_creations(Face polygon) { *current = numbers[polygon]; }
  void after_subface_created(Face triangle) { numbers[triangle] = *current; }
  void after_subface_creations() {}
};

}  // namespace

ReadBudget budget_for_checks(const std::string& file, const PolygonSoup& soup) {
  // Faces of 16,000 corners, or as many about one vertex, which take seconds.
  constexpr std::uint64_t at_least = std::uint64_t{512} << 20U;
  std::uint64_t bytes = soup.points.size() * sizeof(Vec3);
  for (const auto& polygon : soup.polygons) bytes += polygon.size() * sizeof(std::size_t);
  return {file, bytes, at_least};
}

bool cut_into_triangles(SurfaceMesh& surface, FaceNumbers numbers, const std::string& file, ReadBudget& budget) {
  charge(surface, numbers, file, budget);
  std::size_t current = 0;
  return pmp::triangulate_faces(surface, CGAL::parameters::visitor(KeepNumber(numbers, &current)));
}

}  // namespace tactor
