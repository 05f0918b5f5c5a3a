#include "nodes/physics/cgal/exact_distance.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include "nodes/physics/geometry/surface.hpp"

namespace tactor {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Triangles = std::vector<Kernel::Triangle_3>;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, Triangles::const_iterator>;
using Traits = CGAL::AABB_traits<Kernel, Primitive>;
using Tree = CGAL::AABB_tree<Traits>;

Triangles cgal_triangles(const Surface& surface) {
  Triangles triangles;
  triangles.reserve(surface.corners.size());
  const auto point = [](const Vec3& v) { return Kernel::Point_3(v.x, v.y, v.z); };
  for (const auto& c : surface.corners) triangles.emplace_back(point(c[0]), point(c[1]), point(c[2]));
  return triangles;
}

/// Goes through the tree, nearer children first, to the nearest face of the lowest index. CGAL's own closest point
/// leaves open which of several faces it names.
class Search {
 public:
  using Priority = double;
  Search(const Surface& surface, Triangles::const_iterator first, NearestFace& best)
      : surface_(surface), first_(first), best_(best) {}

  [[nodiscard]] static constexpr bool go_further() { return true; }
  void intersection(const Vec3& x, const Primitive& primitive) {
    surface_.compare(static_cast<int>(primitive.id() - first_), x, best_);
  }
  template <class Node>
  [[nodiscard]] bool do_intersect(const Vec3& x, const Node& node) const {
    return do_intersect_with_priority(x, node).first;
  }
  template <class Node>
  [[nodiscard]] std::pair<bool, Priority> do_intersect_with_priority(const Vec3& x, const Node& node) const {
    const CGAL::Bbox_3& box = node.bbox();
    double apart = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double d = std::max({box.min(axis) - x[axis], x[axis] - box.max(axis), 0.0});
      apart += d * d;
    }
    // Rounding must not leave out a face that is as near as the best.
    return {apart <= best_.squared * (1 + 1e-9) + 1e-18, -apart};
  }

 private:
  const Surface& surface_;
  Triangles::const_iterator first_;
  NearestFace& best_;
};

}  // namespace

struct ExactDistance::Impl {
  explicit Impl(const TriangleMesh& mesh)
      : surface(mesh), triangles(cgal_triangles(surface)), tree(triangles.cbegin(), triangles.cend()) {
    tree.build();
  }

  Surface surface;
  Triangles triangles;
  Tree tree;
};

ExactDistance::ExactDistance(const TriangleMesh& mesh) : impl_(std::make_unique<Impl>(mesh)) {}
ExactDistance::~ExactDistance() = default;
ExactDistance::ExactDistance(ExactDistance&&) noexcept = default;
ExactDistance& ExactDistance::operator=(ExactDistance&&) noexcept = default;

Nearest ExactDistance::nearest(const Vec3& x, int hint) const {
  NearestFace best = impl_->surface.candidate(std::max(hint, 0), x);
  Search search(impl_->surface, impl_->triangles.cbegin(), best);
  impl_->tree.traversal_with_priority(x, search);
  return impl_->surface.signed_distance(best, x);
}

Eigen::Matrix3d ExactDistance::hessian(const Nearest& nearest, const Vec3& /*x*/) const {
  return impl_->surface.hessian(nearest);
}

}  // namespace tactor
