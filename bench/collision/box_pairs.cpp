#include <CGAL/Cartesian_converter.h>
#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>
#include <CGAL/intersections.h>

#include "bench/collision/peers.hpp"

namespace tactor::bench {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
// For where triangles meet: nearly parallel ones give NaN in doubles, and that ends the program.
using Exact = CGAL::Exact_predicates_exact_constructions_kernel;
using Triangle = Kernel::Triangle_3;
using Box = CGAL::Box_intersection_d::Box_with_info_d<double, 3, int>;

Triangle triangle(const TriangleMesh& mesh, const std::array<int, 3>& face, const Pose& X) {
  const auto point = [&](int i) {
    const Vec3 p = transform(X, mesh.vertices[static_cast<std::size_t>(i)]);
    return Kernel::Point_3(p.x, p.y, p.z);
  };
  return {point(face[0]), point(face[1]), point(face[2])};
}

class BoxPairs final : public Contender {
 public:
  explicit BoxPairs(const Pair& pair) : tool_mesh_(pair.tool.mesh) { place(pair.fixed.mesh, {}, fixed_, fixed_boxes_); }

  void query(const Step& step) override {
    place(tool_mesh_, step.X_AB, tool_, tool_boxes_);
    found_.clear();
    // The sweep orders the boxes it is given.
    CGAL::box_intersection_d(fixed_boxes_.begin(), fixed_boxes_.end(), tool_boxes_.begin(), tool_boxes_.end(),
                             [&](const Box& a, const Box& b) {
                               if (CGAL::do_intersect(at(fixed_, a.info()), at(tool_, b.info())))
                                 found_.emplace_back(a.info(), b.info());
                             });
  }
  [[nodiscard]] bool touching() const override { return !found_.empty(); }

  /// The ends and the middle of each segment in which two faces meet.
  [[nodiscard]] Touches touches() const override {
    const CGAL::Cartesian_converter<Kernel, Exact> exact;
    const auto vector = [](const Exact::Point_3& p) -> Vec3 {
      return {CGAL::to_double(p.x()), CGAL::to_double(p.y()), CGAL::to_double(p.z())};
    };
    Touches touches;
    for (const auto& [a, b] : found_) {
      const auto met = CGAL::intersection(exact(at(fixed_, a)), exact(at(tool_, b)));
      if (!met) continue;
      if (const auto* s = boost::get<Exact::Segment_3>(&*met)) {
        const Vec3 from = vector(s->source()), to = vector(s->target());
        for (const double t : {0.0, 0.5, 1.0}) touches.push_back({from + t * (to - from), {}, 0});
      } else if (const auto* p = boost::get<Exact::Point_3>(&*met)) {
        touches.push_back({vector(*p), {}, 0});
      }
    }
    return touches;
  }

 private:
  static const Triangle& at(const std::vector<Triangle>& list, int i) { return list[static_cast<std::size_t>(i)]; }
  static void place(const TriangleMesh& mesh, const Pose& X, std::vector<Triangle>& triangles,
                    std::vector<Box>& boxes) {
    triangles.clear();
    boxes.clear();
    for (const auto& f : mesh.faces) {
      triangles.push_back(triangle(mesh, f, X));
      boxes.emplace_back(triangles.back().bbox(), static_cast<int>(boxes.size()));
    }
  }

  const TriangleMesh& tool_mesh_;
  std::vector<Triangle> fixed_, tool_;
  std::vector<Box> fixed_boxes_, tool_boxes_;
  std::vector<std::pair<int, int>> found_;
};

}  // namespace

std::unique_ptr<Contender> make_box_pairs(const Pair& pair) {
  return std::make_unique<BoxPairs>(pair);
}

}  // namespace tactor::bench
