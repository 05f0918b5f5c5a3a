#include <CGAL/Polygon_mesh_processing/corefinement.h>

#include "nodes/physics/cgal/surface_mesh.hpp"
#include "nodes/physics/cgal/surface_rework.hpp"

namespace tactor {

namespace pmp = CGAL::Polygon_mesh_processing;

TriangleMesh united(const TriangleMesh& a, const TriangleMesh& b) {
  SurfaceMesh first = surface_of(a), second = surface_of(b), both;
  if (!pmp::does_bound_a_volume(first) || !pmp::does_bound_a_volume(second)) return {};
  try {
    if (!pmp::corefine_and_compute_union(first, second, both, CGAL::parameters::throw_on_self_intersection(true))) {
      return {};
    }
  } catch (const pmp::Corefinement::Self_intersection_exception&) {
    return {};
  }
  both.collect_garbage();
  remove_flat_faces(both);
  remove_isolated_vertices(both);
  return triangles_of(both);
}

}  // namespace tactor
