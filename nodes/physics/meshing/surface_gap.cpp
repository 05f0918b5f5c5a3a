#include <algorithm>
#include <limits>
#include <set>

#include <CGAL/AABB_face_graph_triangle_primitive.h>
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/Kernel/global_functions_3.h>
#include <CGAL/Polygon_mesh_processing/distance.h>
#include <CGAL/Side_of_triangle_mesh.h>

#include "nodes/physics/cgal/surface_mesh.hpp"
#include "nodes/physics/meshing/surface_rework.hpp"

namespace tactor {

namespace pmp = CGAL::Polygon_mesh_processing;

namespace {

using Coordinates = std::array<double, 9>;

Point point_of(const Vec3& p) {
  return {p.x, p.y, p.z};
}

/// The same for a triangle from whichever corner it begins, and whichever way it goes.
Coordinates key_of(const Corners& triangle) {
  std::array<std::array<double, 3>, 3> corners;
  for (std::size_t i = 0; i < 3; ++i) corners[i] = {triangle[i].x, triangle[i].y, triangle[i].z};
  std::sort(corners.begin(), corners.end());
  Coordinates key;
  for (std::size_t i = 0; i < 9; ++i) key[i] = corners[i / 3][i % 3];
  return key;
}

/// Triangles that share nothing, as a surface.
SurfaceMesh loose_triangles(const std::vector<Corners>& triangles, const std::set<Coordinates>& without) {
  SurfaceMesh surface;
  for (const Corners& t : triangles) {
    const Point a = point_of(t[0]), b = point_of(t[1]), c = point_of(t[2]);
    if (CGAL::collinear(a, b, c) || without.contains(key_of(t))) continue;
    surface.add_face(surface.add_vertex(a), surface.add_vertex(b), surface.add_vertex(c));
  }
  return surface;
}

}  // namespace

double largest_gap(const std::vector<Corners>& from, const std::vector<Corners>& to, double error) {
  std::set<Coordinates> common;
  for (const Corners& t : to) common.insert(key_of(t));
  const SurfaceMesh moving = loose_triangles(from, common), target = loose_triangles(to, {});
  if (moving.is_empty()) return 0;
  const auto plain = CGAL::parameters::match_faces(false);
  return pmp::bounded_error_Hausdorff_distance<CGAL::Sequential_tag>(moving, target, error / 2, plain, plain) +
         error / 2;
}

std::vector<double> gaps_of(const std::vector<Vec3>& points, const std::vector<Corners>& triangles) {
  using Primitive = CGAL::AABB_face_graph_triangle_primitive<SurfaceMesh>;
  const SurfaceMesh surface = loose_triangles(triangles, {});
  if (surface.is_empty()) return std::vector<double>(points.size(), std::numeric_limits<double>::infinity());
  const CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>> tree(faces(surface).begin(), faces(surface).end(),
                                                                   surface);
  std::vector<double> gaps;
  gaps.reserve(points.size());
  for (const Vec3& p : points) gaps.push_back(std::sqrt(tree.squared_distance(point_of(p))));
  return gaps;
}

std::vector<bool> inside_of(const std::vector<Vec3>& points, const TriangleMesh& closed) {
  const SurfaceMesh surface = surface_of(closed);
  const CGAL::Side_of_triangle_mesh<SurfaceMesh, Kernel> side(surface);
  std::vector<bool> inside;
  inside.reserve(points.size());
  for (const Vec3& p : points) inside.push_back(side(point_of(p)) == CGAL::ON_BOUNDED_SIDE);
  return inside;
}

}  // namespace tactor
