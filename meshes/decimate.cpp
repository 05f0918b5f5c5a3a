#include "meshes/decimate.hpp"

#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Bounded_normal_change_filter.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Count_stop_predicate.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/GarlandHeckbert_policies.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>

#include "framework/core/check.hpp"
#include "nodes/physics/cgal/surface_mesh.hpp"

namespace tactor {

namespace sms = CGAL::Surface_mesh_simplification;

TriangleMesh decimate(const TriangleMesh& source, std::size_t faces, const std::string& name) {
  using Policies = sms::GarlandHeckbert_plane_policies<SurfaceMesh, Kernel>;
  if (source.faces.size() < faces) {
    throw RunError(name + ": has " + std::to_string(source.faces.size()) + " faces, fewer than the " +
                   std::to_string(faces) + " asked for");
  }
  SurfaceMesh surface = surface_of(source);
  if (surface.is_empty() || !CGAL::is_closed(surface)) throw RunError(name + ": the source is not a closed manifold");
  if (!is_outward_oriented(surface)) throw RunError(name + ": the source looks inwards");
  const Policies policies(surface);
  // A closed surface has 3/2 edges to a face.
  sms::edge_collapse(surface, sms::Count_stop_predicate<SurfaceMesh>(faces * 3 / 2 + 1),
                     CGAL::parameters::get_cost(policies.get_cost())
                         .get_placement(policies.get_placement())
                         .filter(sms::Bounded_normal_change_filter<>()));
  surface.collect_garbage();
  TriangleMesh mesh = triangles_of(surface);
  if (mesh.faces.size() != faces) {
    throw RunError(name + ": decimated to " + std::to_string(mesh.faces.size()) + " faces, not to " +
                   std::to_string(faces));
  }
  if (!CGAL::is_closed(surface) || !self_intersections(surface, 1).empty() || !is_outward_oriented(surface)) {
    throw RunError(name + ": the decimated surface is open, cuts itself or looks inwards");
  }
  return mesh;
}

}  // namespace tactor
