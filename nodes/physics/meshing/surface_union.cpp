#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/corefinement.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/repair_degeneracies.h>
#include <CGAL/version.h>

#include "nodes/physics/cgal/surface_mesh.hpp"
#include "nodes/physics/mesh/bounds.hpp"
#include "nodes/physics/meshing/surface_rework.hpp"

namespace tactor {

namespace pmp = CGAL::Polygon_mesh_processing;

namespace {

/// Where surfaces cross near an edge, slivers come about whose direction is lost in rounding.
void remove_slivers(SurfaceMesh& surface, double length) {
  constexpr double flat_angle = -0.9999999, longest_to_shortest = 1e4, shortest = 1e-6;
#if CGAL_VERSION_MAJOR >= 6
  pmp::remove_almost_degenerate_faces(faces(surface), surface,
                                      CGAL::parameters::cap_threshold(flat_angle)
                                          .needle_threshold(longest_to_shortest)
                                          .collapse_length_threshold(shortest * length));
#else
  pmp::experimental::remove_almost_degenerate_faces(faces(surface), surface, flat_angle, longest_to_shortest,
                                                    shortest * length);
#endif
  surface.collect_garbage();
}

double solid_angle(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double la = norm(a), lb = norm(b), lc = norm(c);
  return 2 * std::atan2(dot(cross(a, b), c), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
}

/// How often a closed mesh goes round a point, near which none of its corners lies.
long winding_number(const TriangleMesh& mesh, const Vec3& p) {
  double sum = 0;
  for (const auto& f : mesh.faces) {
    const auto corner = [&](std::size_t k) { return mesh.vertices[static_cast<std::size_t>(f[k])] - p; };
    sum += solid_angle(corner(0), corner(1), corner(2));
  }
  return std::lround(sum / (4 * std::numbers::pi));
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

TriangleMesh outermost(const TriangleMesh& mesh) {
  SurfaceMesh surface = surface_of(mesh);
  const auto cut = surface.add_property_map<SurfaceMesh::Edge_index, bool>("e:cut", false).first;
  const auto patch = surface.add_property_map<Face, std::size_t>("f:patch", 0).first;
  try {
    pmp::experimental::autorefine(surface, CGAL::parameters::edge_is_constrained_map(cut));
  } catch (const pmp::Corefinement::Triple_intersection_exception&) {
    return {};
  } catch (const pmp::Corefinement::Self_intersection_exception&) {
    return {};
  }
  surface.collect_garbage();
  // Which side of a patch is inside is the same all over it, and its largest face tells.
  const std::size_t patches = pmp::connected_components(surface, patch, CGAL::parameters::edge_is_constrained_map(cut));
  std::vector<double> largest(patches, 0);
  std::vector<Vec3> middle(patches), normal(patches);
  for (const Face f : surface.faces()) {
    std::array<Vec3, 3> corner;
    std::size_t k = 0;
    for (const auto v : corners_of(surface, f)) {
      const Point& p = surface.point(v);
      corner[k++] = {p.x(), p.y(), p.z()};
    }
    const Vec3 doubled = cross(corner[1] - corner[0], corner[2] - corner[0]);
    if (!(norm(doubled) > largest[patch[f]])) continue;
    largest[patch[f]] = norm(doubled);
    normal[patch[f]] = doubled / norm(doubled);
    middle[patch[f]] = (corner[0] + corner[1] + corner[2]) / 3;
  }
  const double aside = 1e-9 * norm(bounds_of(mesh).size());
  std::vector<bool> bounds(patches, false);
  for (std::size_t i = 0; i < patches; ++i) {
    bounds[i] = largest[i] > 0 && winding_number(mesh, middle[i] + aside * normal[i]) <= 0 &&
                winding_number(mesh, middle[i] - aside * normal[i]) > 0;
  }
  std::vector<Point> points;
  for (const auto v : surface.vertices()) points.push_back(surface.point(v));
  std::vector<std::vector<std::size_t>> triangles;
  for (const Face f : surface.faces()) {
    if (!bounds[patch[f]]) continue;
    triangles.emplace_back();
    for (const auto v : corners_of(surface, f)) triangles.back().push_back(v.idx());
  }
  // Patches that meet four at an edge bound no solid.
  if (triangles.empty() || !pmp::is_polygon_soup_a_polygon_mesh(triangles)) return {};
  SurfaceMesh outer = surface_of(stitched(points, triangles));
  if (!CGAL::is_closed(outer)) return {};
  remove_flat_faces(outer);
  remove_slivers(outer, bounds_of(mesh).longest());
  remove_isolated_vertices(outer);
  return triangles_of(outer);
}

}  // namespace tactor
