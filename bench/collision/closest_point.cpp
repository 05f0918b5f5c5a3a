#include "bench/collision/closest_point.hpp"

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include "nodes/physics/cgal/exact_distance.hpp"
#include "nodes/physics/geometry/cell_distance.hpp"

namespace tactor::bench {

namespace {

/// Begins at the face it found last.
template <class Distance>
class Hinted final : public ClosestPoint {
 public:
  explicit Hinted(const TriangleMesh& mesh) : distance_(mesh) {}
  double distance(const Vec3& x) override {
    const Nearest nearest = distance_.nearest(x, face_);
    face_ = nearest.face;
    return nearest.distance;
  }

 private:
  Distance distance_;
  int face_ = -1;
};

class CgalClosest final : public ClosestPoint {
 public:
  explicit CgalClosest(const TriangleMesh& mesh)
      : triangles_(triangles(mesh)), tree_(triangles_.begin(), triangles_.end()) {
    tree_.build();
    tree_.accelerate_distance_queries();
  }
  double distance(const Vec3& x) override { return std::sqrt(tree_.squared_distance({x.x, x.y, x.z})); }

 private:
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  using Triangles = std::vector<Kernel::Triangle_3>;
  using Tree =
      CGAL::AABB_tree<CGAL::AABB_traits<Kernel, CGAL::AABB_triangle_primitive<Kernel, Triangles::const_iterator>>>;

  static Triangles triangles(const TriangleMesh& mesh) {
    Triangles list;
    const auto point = [&](int i) {
      const Vec3& v = mesh.vertices[static_cast<std::size_t>(i)];
      return Kernel::Point_3(v.x, v.y, v.z);
    };
    for (const auto& f : mesh.faces) list.emplace_back(point(f[0]), point(f[1]), point(f[2]));
    return list;
  }

  Triangles triangles_;
  Tree tree_;
};

}  // namespace

std::unique_ptr<ClosestPoint> make_cell_distance(const TriangleMesh& mesh) {
  return std::make_unique<Hinted<CellDistance>>(mesh);
}
std::unique_ptr<ClosestPoint> make_exact_distance(const TriangleMesh& mesh) {
  return std::make_unique<Hinted<ExactDistance>>(mesh);
}
std::unique_ptr<ClosestPoint> make_cgal_closest(const TriangleMesh& mesh) {
  return std::make_unique<CgalClosest>(mesh);
}

}  // namespace tactor::bench
