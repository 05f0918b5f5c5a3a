#include "app/new/touch_path.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/physics/geometry/tree_distance.hpp"
#include "nodes/physics/mesh/bounds.hpp"

namespace tactor {

namespace {

class PathSearch {
 public:
  PathSearch(const TriangleMesh& mesh, double radius)
      : mesh_(mesh), distance_(mesh), bounds_(bounds_of(mesh)), radius_(radius) {}

  TouchPath best(double length, int steps) {
    TouchPath best;
    std::size_t tried = 0;
    for (const TouchPoint& start : candidates()) {
      if (!is_free(start)) continue;
      constexpr int directions = 8;
      for (int k = 0; k < directions; ++k) {
        TouchPath path = slide(start, 2 * std::numbers::pi * k / directions, length / steps, steps);
        if (path.size() > best.size()) best = std::move(path);
        if (best.size() == static_cast<std::size_t>(steps) + 1) return best;
      }
      constexpr std::size_t enough = 50;
      if (++tried >= enough) break;
    }
    return best.empty() ? TouchPath{topmost()} : best;
  }

 private:
  /// Middles of faces, those first that look up and lie in the middle.
  std::vector<TouchPoint> candidates() const {
    constexpr std::size_t most = 2000;
    const std::size_t stride = 1 + mesh_.faces.size() / most;
    std::vector<std::pair<double, TouchPoint>> scored;
    for (std::size_t f = 0; f < mesh_.faces.size(); f += stride) {
      const auto& face = mesh_.faces[f];
      const Vec3 doubled = doubled_area_normal(mesh_, face);
      if (!(norm(doubled) > 0)) continue;
      const Vec3 n = doubled / norm(doubled);
      Vec3 middle;
      for (const int corner : face) middle += mesh_.vertices[static_cast<std::size_t>(corner)] / 3;
      Vec3 aside = middle - bounds_.middle();
      aside.z = 0;
      scored.emplace_back(norm(aside) / bounds_.longest() - n.z, TouchPoint{middle + radius_ * n, n});
    }
    std::stable_sort(scored.begin(), scored.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<TouchPoint> points;
    for (const auto& [score, point] : scored) points.push_back(point);
    return points;
  }

  /// Whether the ball can go from there along the normal out of the bounds.
  bool is_free(const TouchPoint& at) const {
    const double out = norm(bounds_.size()) + 2 * radius_;
    double way = 0;
    for (int step = 0; step < 1000 && way < out; ++step) {
      const double d = distance_.nearest(at.p + way * at.normal).distance;
      if (d < slack * radius_) return false;
      // No surface comes nearer than a radius within this.
      way += std::max(d - slack * radius_, 0.05 * radius_);
    }
    return way >= out;
  }

  TouchPath slide(const TouchPoint& start, double angle, double step, int steps) const {
    const Vec3 any = std::abs(start.normal.x) < 0.9 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
    const Vec3 across = cross(start.normal, any) / norm(cross(start.normal, any));
    Vec3 along = std::cos(angle) * across + std::sin(angle) * cross(start.normal, across);
    TouchPath path{start};
    while (path.size() <= static_cast<std::size_t>(steps)) {
      TouchPoint at = path.back();
      constexpr int pieces = 8;  // so that a spline through the places keeps to the surface
      bool on = true;
      for (int i = 0; i < pieces && on; ++i) on = advance(at, along, step / pieces);
      if (!on || dot(at.normal, path.back().normal) < 0.7) break;
      path.push_back(at);
    }
    while (path.size() > 1 && !is_free(path.back())) path.pop_back();
    return path;
  }

  /// Moves over the surface; false where it bends away too sharply or something stands in the way.
  bool advance(TouchPoint& at, Vec3& along, double way) const {
    const Nearest there = distance_.nearest(at.p + way * along);
    const Vec3 p = there.p + radius_ * there.gradient;
    const Vec3 moved = p - at.p;
    if (there.distance <= 0 || norm(moved) > 2 * way || dot(there.gradient, at.normal) < 0.5) return false;
    if (distance_.nearest(p).distance < slack * radius_) return false;
    const Vec3 tangent = along - dot(along, there.gradient) * there.gradient;
    if (!(norm(tangent) > 0.1)) return false;
    at = {p, there.gradient};
    along = tangent / norm(tangent);
    return true;
  }

  /// The highest vertex, from straight above: nothing can be in the way.
  TouchPoint topmost() const {
    const Vec3 top = *std::max_element(mesh_.vertices.begin(), mesh_.vertices.end(),
                                       [](const Vec3& a, const Vec3& b) { return a.z < b.z; });
    return {top + Vec3{0, 0, radius_}, {0, 0, 1}};
  }

  static constexpr double slack = 0.98;
  const TriangleMesh& mesh_;
  TreeDistance distance_;
  Bounds bounds_;
  double radius_;
};

}  // namespace

TouchPath find_touch_path(const TriangleMesh& mesh, double radius, double length, int steps) {
  return PathSearch(mesh, radius).best(length, steps);
}

}  // namespace tactor
