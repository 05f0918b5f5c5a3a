#include <CGAL/Polygon_mesh_processing/corefinement.h>
#include <CGAL/Polygon_mesh_processing/repair_degeneracies.h>

#include "nodes/physics/cgal/surface_mesh.hpp"
#include "nodes/physics/cgal/surface_rework.hpp"
#include "nodes/physics/mesh/bounds.hpp"

namespace tactor {

namespace pmp = CGAL::Polygon_mesh_processing;

namespace {

/// Where surfaces cross near an edge, slivers come about whose direction is lost in rounding.
void remove_slivers(SurfaceMesh& surface, double length) {
  constexpr double flat_angle = -0.9999999, longest_to_shortest = 1e4, shortest = 1e-6;
  pmp::experimental::remove_almost_degenerate_faces(faces(surface), surface, flat_angle, longest_to_shortest,
                                                    shortest * length);
  surface.collect_garbage();
}

}  // namespace

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
  remove_slivers(both, bounds_of(a).longest());
  remove_isolated_vertices(both);
  return triangles_of(both);
}

}  // namespace tactor
