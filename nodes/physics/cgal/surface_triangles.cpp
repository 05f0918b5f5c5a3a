#include "nodes/physics/cgal/surface_mesh.hpp"

#include <CGAL/Polygon_mesh_processing/triangulate_faces.h>

namespace tactor {

namespace pmp = CGAL::Polygon_mesh_processing;

namespace {

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

bool cut_into_triangles(SurfaceMesh& surface, FaceNumbers numbers) {
  std::size_t current = 0;
  return pmp::triangulate_faces(surface, CGAL::parameters::visitor(KeepNumber(numbers, &current)));
}

}  // namespace tactor
