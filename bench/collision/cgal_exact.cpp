#include "bench/collision/cgal_exact.hpp"

#include <CGAL/AABB_face_graph_triangle_primitive.h>
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/bbox.h>
#include <CGAL/Side_of_triangle_mesh.h>
#include <CGAL/Surface_mesh.h>

namespace tactor::bench {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Surface = CGAL::Surface_mesh<Kernel::Point_3>;
using Inside = CGAL::Side_of_triangle_mesh<Surface, Kernel>;
using Tree = Inside::AABB_tree;

Surface surface_of(const TriangleMesh& mesh) {
  Surface surface;
  for (const Vec3& v : mesh.vertices) surface.add_vertex({v.x, v.y, v.z});
  const auto vertex = [](int i) { return Surface::Vertex_index(static_cast<Surface::size_type>(i)); };
  for (const auto& f : mesh.faces) surface.add_face(vertex(f[0]), vertex(f[1]), vertex(f[2]));
  return surface;
}

class Solid {
 public:
  explicit Solid(const TriangleMesh& mesh)
      : surface_(surface_of(mesh)),
        box_(CGAL::Polygon_mesh_processing::bbox(surface_)),
        tree_(faces(surface_).begin(), faces(surface_).end(), surface_),
        inside_(tree_) {
    tree_.build();
    tree_.accelerate_distance_queries();
  }

  /// Puts the samples that are inside into `found`, with points and normals in the frame of the solid.
  void find(const std::vector<SurfaceSample>& samples, const Pose& X_SO, Side side, Touches& found) const {
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const Vec3 x = transform(X_SO, samples[i].p);
      if (x.x < box_.xmin() || x.x > box_.xmax() || x.y < box_.ymin() || x.y > box_.ymax() || x.z < box_.zmin() ||
          x.z > box_.zmax()) {
        continue;
      }
      const Kernel::Point_3 point(x.x, x.y, x.z);
      if (inside_(point) != CGAL::ON_BOUNDED_SIDE) continue;
      const auto [p, face] = tree_.closest_point_and_primitive(point);
      const Vec3 out = Vec3{p.x(), p.y(), p.z()} - x;
      const double depth = norm(out);
      found.push_back({x, depth > 0 ? out / depth : Vec3{}, depth, side, static_cast<int>(i), static_cast<int>(face)});
    }
  }

 private:
  Surface surface_;
  CGAL::Bbox_3 box_;
  Tree tree_;
  Inside inside_;
};

class CgalExact final : public Contender {
 public:
  explicit CgalExact(const Pair& pair) : pair_(pair), fixed_(pair.fixed.mesh), tool_(pair.tool.mesh) {}

  void query(const Step& step) override {
    found_.clear();
    fixed_.find(pair_.tool.samples, step.X_AB, Side::tool, found_);
    const std::size_t of_tool = found_.size();
    tool_.find(pair_.fixed.samples, inverse(step.X_AB), Side::fixed, found_);
    for (std::size_t i = of_tool; i < found_.size(); ++i) {
      found_[i].p_A = transform(step.X_AB, found_[i].p_A);
      // The fixed body's sample gets out along the normal; the tool goes the other way.
      found_[i].n_A = -rotate(step.X_AB.R, found_[i].n_A);
    }
  }
  [[nodiscard]] bool touching() const override { return !found_.empty(); }
  [[nodiscard]] Touches touches() const override { return found_; }

 private:
  const Pair& pair_;
  Solid fixed_, tool_;
  Touches found_;
};

}  // namespace

std::unique_ptr<Contender> make_cgal_exact(const Pair& pair) {
  return std::make_unique<CgalExact>(pair);
}

}  // namespace tactor::bench
