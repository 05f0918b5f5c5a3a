#include "meshes/decimate.hpp"

#include "framework/core/check.hpp"
#include "nodes/physics/cgal/surface_mesh.hpp"

namespace tactor {

TriangleMesh decimate(const TriangleMesh& source, std::size_t faces, const std::string& name) {
  if (source.faces.size() < faces) {
    throw RunError(name + ": has " + std::to_string(source.faces.size()) + " faces, fewer than the " +
                   std::to_string(faces) + " asked for");
  }
  const SurfaceMesh before = surface_of(source);
  if (before.is_empty() || !CGAL::is_closed(before)) throw RunError(name + ": the source is not a closed manifold");
  if (!is_outward_oriented(before)) throw RunError(name + ": the source looks inwards");
  TriangleMesh mesh = collapsed(source, faces);
  if (mesh.faces.size() != faces) {
    throw RunError(name + ": decimated to " + std::to_string(mesh.faces.size()) + " faces, not to " +
                   std::to_string(faces));
  }
  const SurfaceMesh surface = surface_of(mesh);
  ReadBudget budget = budget_for_checks(name, soup_of(surface));
  if (!CGAL::is_closed(surface) || !self_intersections(surface, 1, name, budget).empty() ||
      !is_outward_oriented(surface)) {
    throw RunError(name + ": the decimated surface is open, cuts itself or looks inwards");
  }
  return mesh;
}

}  // namespace tactor
