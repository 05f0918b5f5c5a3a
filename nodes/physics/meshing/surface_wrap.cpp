#include <vector>

#include <CGAL/alpha_wrap_3.h>

#include "nodes/physics/cgal/surface_mesh.hpp"
#include "nodes/physics/meshing/surface_rework.hpp"

namespace tactor {

TriangleMesh wrapped_around(const std::vector<Corners>& triangles, double alpha, double offset) {
  std::vector<Point> points;
  std::vector<std::array<std::size_t, 3>> faces;
  for (const Corners& t : triangles) {
    const Point a(t[0].x, t[0].y, t[0].z), b(t[1].x, t[1].y, t[1].z), c(t[2].x, t[2].y, t[2].z);
    if (CGAL::collinear(a, b, c)) continue;
    faces.push_back({points.size(), points.size() + 1, points.size() + 2});
    points.insert(points.end(), {a, b, c});
  }
  SurfaceMesh wrap;
  CGAL::alpha_wrap_3(points, faces, alpha, offset, wrap);
  wrap.collect_garbage();
  return triangles_of(wrap);
}

}  // namespace tactor
