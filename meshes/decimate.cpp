#include "meshes/decimate.hpp"

#include <CGAL/Polygon_mesh_processing/orientation.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Bounded_normal_change_filter.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Count_stop_predicate.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/GarlandHeckbert_policies.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

namespace sms = CGAL::Surface_mesh_simplification;
namespace pmp = CGAL::Polygon_mesh_processing;

}  // namespace

TriangleMesh indexed(Surface& surface) {
  surface.collect_garbage();
  TriangleMesh mesh;
  for (const auto v : surface.vertices()) {
    const auto& p = surface.point(v);
    mesh.vertices.push_back({p.x(), p.y(), p.z()});
  }
  for (const auto f : surface.faces()) {
    std::array<int, 3> corners{};
    std::size_t i = 0;
    for (const auto v : CGAL::vertices_around_face(surface.halfedge(f), surface)) {
      corners[i++] = static_cast<int>(static_cast<std::size_t>(v));
    }
    mesh.faces.push_back(corners);
  }
  return mesh;
}

TriangleMesh decimate(Surface& surface, std::size_t faces, const std::string& name) {
  using Policies = sms::GarlandHeckbert_plane_policies<Surface, SurfaceKernel>;
  if (surface.number_of_faces() < faces) {
    throw RunError(name + ": has " + std::to_string(surface.number_of_faces()) + " faces, fewer than the " +
                   std::to_string(faces) + " asked for");
  }
  if (!CGAL::is_closed(surface) || !CGAL::is_triangle_mesh(surface)) {
    throw RunError(name + ": the source is not a closed triangle mesh");
  }
  if (!pmp::is_outward_oriented(surface)) pmp::reverse_face_orientations(surface);
  const Policies policies(surface);
  // A closed surface has 3/2 edges to a face.
  sms::edge_collapse(surface, sms::Count_stop_predicate<Surface>(faces * 3 / 2 + 1),
                     CGAL::parameters::get_cost(policies.get_cost())
                         .get_placement(policies.get_placement())
                         .filter(sms::Bounded_normal_change_filter<>()));
  TriangleMesh mesh = indexed(surface);
  if (mesh.faces.size() != faces) {
    throw RunError(name + ": decimated to " + std::to_string(mesh.faces.size()) + " faces, not to " +
                   std::to_string(faces));
  }
  if (!CGAL::is_closed(surface) || pmp::does_self_intersect(surface) || !pmp::is_outward_oriented(surface)) {
    throw RunError(name + ": the decimated surface is open, cuts itself or looks inwards");
  }
  return mesh;
}

}  // namespace tactor
