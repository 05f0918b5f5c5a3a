// Ways of finding the point of a mesh that is closest to a point, as contenders.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "nodes/physics/mesh/mesh.hpp"

namespace tactor::bench {

class ClosestPoint {
 public:
  virtual ~ClosestPoint() = default;
  /// The distance of x (m, in the frame of the mesh) to the surface, in m.
  virtual double distance(const Vec3& x) = 0;
};

/// Whether distances inside are negative, or have no sign.
enum class Sign { none, inside_negative };

struct ClosestPointEntry {
  std::string name;
  Sign sign = Sign::none;
  std::function<std::unique_ptr<ClosestPoint>(const TriangleMesh&)> make;
};

/// CellDistance, and ExactDistance, which is CGAL's AABB tree begun at the face found last.
std::unique_ptr<ClosestPoint> make_cell_distance(const TriangleMesh& mesh);
std::unique_ptr<ClosestPoint> make_exact_distance(const TriangleMesh& mesh);
/// CGAL's AABB tree as it comes, with its own k-d tree of hints.
std::unique_ptr<ClosestPoint> make_cgal_closest(const TriangleMesh& mesh);
/// Embree's point query, single precision, with the nearest point of each triangle by our own function.
std::unique_ptr<ClosestPoint> make_embree(const TriangleMesh& mesh);
/// FCL's distance of two meshes, of which one is a triangle of 10 nm at the point; its distance of a sphere to a mesh
/// asks an iterative solver for each triangle.
std::unique_ptr<ClosestPoint> make_fcl_distance(const TriangleMesh& mesh);

}  // namespace tactor::bench
