#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Bounded_normal_change_filter.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Count_stop_predicate.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/GarlandHeckbert_policies.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>

#include "nodes/physics/cgal/surface_mesh.hpp"

namespace tactor {

namespace sms = CGAL::Surface_mesh_simplification;

TriangleMesh collapsed(const TriangleMesh& mesh, std::size_t faces) {
  using Policies = sms::GarlandHeckbert_plane_policies<SurfaceMesh, Kernel>;
  SurfaceMesh surface = surface_of(mesh);
  const Policies policies(surface);
  // A closed surface has 3/2 edges to a face.
  sms::edge_collapse(surface, sms::Count_stop_predicate<SurfaceMesh>(faces * 3 / 2 + 1),
                     CGAL::parameters::get_cost(policies.get_cost())
                         .get_placement(policies.get_placement())
                         .filter(sms::Bounded_normal_change_filter<>()));
  surface.collect_garbage();
  return triangles_of(surface);
}

}  // namespace tactor
