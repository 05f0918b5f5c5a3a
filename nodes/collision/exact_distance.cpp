#include "nodes/collision/exact_distance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

namespace tactor {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Triangles = std::vector<Kernel::Triangle_3>;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, Triangles::const_iterator>;
using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

/// A point of a triangle: on its face, or on edge i (from corner i to i + 1), or at corner i.
struct OnTriangle {
  Vec3 p;
  enum { face, edge, corner } where = face;
  std::size_t i = 0;
};

/// The nearest point of triangle abc to x (C. Ericson, "Real-Time Collision Detection", section 5.1.5).
OnTriangle nearest_on(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& x) {
  const Vec3 ab = b - a, ac = c - a, ax = x - a, bx = x - b, cx = x - c;
  const double d1 = dot(ab, ax), d2 = dot(ac, ax), d3 = dot(ab, bx), d4 = dot(ac, bx), d5 = dot(ab, cx),
               d6 = dot(ac, cx);
  if (d1 <= 0 && d2 <= 0) return {a, OnTriangle::corner, 0};
  if (d3 >= 0 && d4 <= d3) return {b, OnTriangle::corner, 1};
  if (d6 >= 0 && d5 <= d6) return {c, OnTriangle::corner, 2};
  const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {a + d1 / (d1 - d3) * ab, OnTriangle::edge, 0};
  if (va <= 0 && d4 >= d3 && d5 >= d6) {
    return {b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b), OnTriangle::edge, 1};
  }
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {a + d2 / (d2 - d6) * ac, OnTriangle::edge, 2};
  const double scale = 1 / (va + vb + vc);
  return {a + vb * scale * ab + vc * scale * ac, OnTriangle::face, 0};
}

Vec3 unit(const Vec3& v) {
  return v / norm(v);
}

Triangles triangles_of(const TriangleMesh& mesh) {
  Triangles triangles;
  const auto point = [&](int i) {
    const Vec3& v = mesh.vertices[static_cast<std::size_t>(i)];
    return Kernel::Point_3(v.x, v.y, v.z);
  };
  for (const auto& f : mesh.faces) triangles.emplace_back(point(f[0]), point(f[1]), point(f[2]));
  return triangles;
}

}  // namespace

struct ExactDistance::Impl {
  explicit Impl(const TriangleMesh& m)
      : mesh(m), triangles(triangles_of(m)), tree(triangles.cbegin(), triangles.cend()) {
    tree.build();
    // Every query brings a hint of its own.
    tree.do_not_accelerate_distance_queries();
    add_pseudo_normals();
    if (mesh.faces.size() <= scan_limit) add_boxes();
  }

  void add_boxes() {
    for (const auto& f : mesh.faces) {
      Box box{at(f[0]), at(f[0])};
      for (const int corner : f) {
        for (int axis = 0; axis < 3; ++axis) {
          box.low[axis] = std::min(box.low[axis], at(corner)[axis]);
          box.high[axis] = std::max(box.high[axis], at(corner)[axis]);
        }
      }
      boxes.push_back(box);
    }
  }

  [[nodiscard]] OnTriangle nearest_of(std::size_t face, const Vec3& x) const {
    const auto& f = mesh.faces[face];
    return nearest_on(at(f[0]), at(f[1]), at(f[2]), x);
  }

  /// The face nearest to x, given a face and its nearest point to begin with.
  [[nodiscard]] std::size_t search(const Vec3& x, std::size_t start, const Vec3& p) const {
    const auto [point, primitive] = tree.closest_point_and_primitive(
        Kernel::Point_3(x.x, x.y, x.z),
        {Kernel::Point_3(p.x, p.y, p.z), triangles.cbegin() + static_cast<std::ptrdiff_t>(start)});
    return static_cast<std::size_t>(primitive - triangles.cbegin());
  }

  /// The same by looking at every face whose box is near enough.
  [[nodiscard]] std::size_t scan(const Vec3& x, std::size_t start, const Vec3& p) const {
    std::size_t best = start;
    double least = dot(x - p, x - p);
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      double apart = 0;
      for (int axis = 0; axis < 3; ++axis) {
        const double d = std::max({boxes[i].low[axis] - x[axis], x[axis] - boxes[i].high[axis], 0.0});
        apart += d * d;
      }
      if (apart >= least) continue;
      const Vec3 away = x - nearest_of(i, x).p;
      if (const double d = dot(away, away); d < least) least = d, best = i;
    }
    return best;
  }

  void add_pseudo_normals() {
    face_normals.reserve(mesh.faces.size());
    edge_normals.resize(mesh.faces.size());
    vertex_normals.resize(mesh.vertices.size());
    std::map<std::pair<int, int>, Vec3> edges;
    for (const auto& f : mesh.faces) {
      const Vec3 n = unit(doubled_area_normal(mesh, f));
      face_normals.push_back(n);
      for (std::size_t i = 0; i < 3; ++i) {
        const int from = f[i], to = f[(i + 1) % 3], other = f[(i + 2) % 3];
        edges[std::minmax(from, to)] += n;
        const Vec3 u = unit(at(to) - at(from)), v = unit(at(other) - at(from));
        vertex_normals[static_cast<std::size_t>(from)] += std::acos(std::clamp(dot(u, v), -1.0, 1.0)) * n;
      }
    }
    for (std::size_t k = 0; k < mesh.faces.size(); ++k) {
      const auto& f = mesh.faces[k];
      for (std::size_t i = 0; i < 3; ++i) edge_normals[k][i] = unit(edges.at(std::minmax(f[i], f[(i + 1) % 3])));
    }
    for (Vec3& n : vertex_normals) {
      if (norm(n) > 0) n = unit(n);
    }
  }

  [[nodiscard]] const Vec3& at(int i) const { return mesh.vertices[static_cast<std::size_t>(i)]; }

  [[nodiscard]] Vec3 normal(std::size_t face, const OnTriangle& on) const {
    switch (on.where) {
      case OnTriangle::edge:
        return edge_normals[face][on.i];
      case OnTriangle::corner:
        return vertex_normals[static_cast<std::size_t>(mesh.faces[face][on.i])];
      case OnTriangle::face:
        break;
    }
    return face_normals[face];
  }

  // Below this many faces a scan is faster than the tree, above all where faces are long and thin.
  static constexpr std::size_t scan_limit = 512;
  struct Box {
    Vec3 low, high;
  };

  TriangleMesh mesh;
  std::vector<Box> boxes;  // of the faces, where there are few
  Triangles triangles;
  Tree tree;
  std::vector<Vec3> face_normals;
  std::vector<std::array<Vec3, 3>> edge_normals;
  std::vector<Vec3> vertex_normals;
};

ExactDistance::ExactDistance(const TriangleMesh& mesh) : impl_(std::make_unique<Impl>(mesh)) {}
ExactDistance::~ExactDistance() = default;
ExactDistance::ExactDistance(ExactDistance&&) noexcept = default;
ExactDistance& ExactDistance::operator=(ExactDistance&&) noexcept = default;

Nearest ExactDistance::query(const Vec3& x, int hint) const {
  const auto start = static_cast<std::size_t>(std::max(hint, 0));
  const Vec3 guess = impl_->nearest_of(start, x).p;
  const std::size_t face = impl_->boxes.empty() ? impl_->search(x, start, guess) : impl_->scan(x, start, guess);
  const OnTriangle on = impl_->nearest_of(face, x);

  const Vec3 away = x - on.p;
  const Vec3 n = impl_->normal(face, on);
  const double length = norm(away);
  const double sign = dot(away, n) < 0 ? -1 : 1;
  // Nearer than rounding to the surface, the difference has no direction.
  const bool on_surface = length < 1e-12;
  return {sign * length, on.p, on_surface ? n : away * (sign / length), static_cast<int>(face)};
}

}  // namespace tactor
