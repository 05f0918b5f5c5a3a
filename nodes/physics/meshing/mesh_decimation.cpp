#include <string>

#include "framework/core/check.hpp"
#include "nodes/physics/cgal/mesh_repair.hpp"
#include "nodes/physics/cgal/surface_mesh.hpp"
#include "nodes/physics/mesh/bounds.hpp"
#include "nodes/physics/mesh/mass_properties.hpp"
#include "nodes/physics/meshing/mesh_parts.hpp"
#include "nodes/physics/meshing/mesh_rework.hpp"
#include "nodes/physics/meshing/surface_rework.hpp"

namespace tactor {

MeshChange decimated_solid(const TriangleMesh& solid, std::size_t faces, const std::string& file) {
  const std::size_t even = faces - faces % 2;
  if (solid.faces.size() < even) {
    throw InputError(file + ": the mesh has " + std::to_string(solid.faces.size()) + " faces, fewer than the " +
                     std::to_string(faces) + " asked for; a mesh is not made finer");
  }
  TriangleMesh mesh = collapsed(solid, even);
  if (mesh.faces.size() > even) {
    throw InputError(file + ": no edge can be collapsed below " + std::to_string(mesh.faces.size()) +
                     " faces without folding the surface; ask for as many");
  }
  MeshChange change;
  ReadBudget budget = budget_for_checks(file, soup_of(mesh));
  if (!self_intersections(surface_of(mesh), 1, file, budget).empty()) {
    mesh = untangled(mesh);
    change.changes.emplace_back("places where the coarser surface cut itself were smoothed or filled anew");
  }
  MeshReport report;
  try {
    change.mesh = repaired_solid(soup_of(mesh), file, report);
  } catch (const InputError& error) {
    throw InputError(std::string(error.what()) + "; this is so after decimation to " + std::to_string(even) +
                     " faces: ask for more");
  }
  change.report.warnings = report.warnings;
  const auto before = triangle_list(solid), now = triangle_list(change.mesh);
  change.moved_error = 1e-4 * norm(bounds_of(solid).size());
  change.old_to_new = largest_gap(before, now, change.moved_error);
  change.new_to_old = largest_gap(now, before, change.moved_error);
  change.old_volume = mass_properties(solid).volume;
  change.new_volume = mass_properties(change.mesh).volume;
  change.changes.insert(change.changes.begin(), std::to_string(solid.faces.size()) + " faces became " +
                                                    std::to_string(change.mesh.faces.size()));
  return change;
}

}  // namespace tactor
