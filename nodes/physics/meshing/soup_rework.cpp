#include "nodes/physics/meshing/soup_rework.hpp"

#include <algorithm>
#include <boost/geometry.hpp>
#include <boost/geometry/index/rtree.hpp>
#include <map>
#include <numeric>
#include <utility>

#include "nodes/physics/mesh/disjoint_sets.hpp"

namespace tactor {

namespace {

using Edge = std::pair<std::size_t, std::size_t>;

Edge edge_of(std::size_t a, std::size_t b) {
  return {std::min(a, b), std::max(a, b)};
}

/// The faces at each edge.
std::map<Edge, std::vector<std::size_t>> faces_at_edges(const NumberedSoup& soup) {
  std::map<Edge, std::vector<std::size_t>> found;
  for (std::size_t f = 0; f < soup.polygons.size(); ++f) {
    const auto& p = soup.polygons[f];
    for (std::size_t k = 0; k < p.size(); ++k) found[edge_of(p[k], p[(k + 1) % p.size()])].push_back(f);
  }
  return found;
}

/// The points of open edges, by their numbers.
std::vector<std::size_t> rim_points(const NumberedSoup& soup) {
  std::vector<std::size_t> points;
  for (const auto& [edge, faces] : faces_at_edges(soup)) {
    if (faces.size() == 1) points.insert(points.end(), {edge.first, edge.second});
  }
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
  return points;
}

/// Points of a soup by their places.
class PointTree {
 public:
  explicit PointTree(const NumberedSoup& soup) : soup_(soup) {}
  void insert(std::size_t i) { tree_.insert({tree_point(soup_.points[i]), i}); }
  /// Calls `work(i)` for each point within `reach` of the box that two points span, in any order.
  template <class Work>
  void for_each_near(const Vec3& a, const Vec3& b, double reach, const Work& work) const {
    const Vec3 low{std::min(a.x, b.x) - reach, std::min(a.y, b.y) - reach, std::min(a.z, b.z) - reach};
    const Vec3 high{std::max(a.x, b.x) + reach, std::max(a.y, b.y) + reach, std::max(a.z, b.z) + reach};
    const boost::geometry::model::box<TreePoint> box(tree_point(low), tree_point(high));
    for (auto at = tree_.qbegin(boost::geometry::index::intersects(box)); at != tree_.qend(); ++at) work(at->second);
  }

 private:
  using TreePoint = boost::geometry::model::point<double, 3, boost::geometry::cs::cartesian>;
  static TreePoint tree_point(const Vec3& p) { return {p.x, p.y, p.z}; }

  const NumberedSoup& soup_;
  boost::geometry::index::rtree<std::pair<TreePoint, std::size_t>, boost::geometry::index::quadratic<16>> tree_;
};

void drop_collapsed(NumberedSoup& soup) {
  std::vector<bool> drop(soup.polygons.size(), false);
  for (std::size_t f = 0; f < soup.polygons.size(); ++f) {
    const auto& p = soup.polygons[f];
    drop[f] = p[0] == p[1] || p[1] == p[2] || p[2] == p[0];
  }
  remove_polygons(soup, drop);
}

/// Faces that hang together by edges of two faces.
struct Patch {
  double area = 0;
  std::size_t open = 0;        // edges of one face
  std::vector<Edge> branches;  // edges of more than two
};

/// Takes out the patches that may go, the smallest first. Returns how many faces.
std::size_t remove_fins_once(NumberedSoup& soup, std::vector<std::size_t>& removed) {
  constexpr double small = 0.01;  // of the area, for a piece that ends freely
  const auto edges = faces_at_edges(soup);
  DisjointSets sets(soup.polygons.size());
  for (const auto& [edge, faces] : edges) {
    if (faces.size() == 2) sets.unite(faces[0], faces[1]);
  }
  std::map<std::size_t, Patch> patches;
  double area = 0;
  for (std::size_t f = 0; f < soup.polygons.size(); ++f) {
    const double a = area_of(soup, f);
    patches[sets.root(f)].area += a;
    area += a;
  }
  std::map<Edge, std::size_t> sides;
  for (const auto& [edge, faces] : edges) {
    if (faces.size() == 1) ++patches[sets.root(faces[0])].open;
    if (faces.size() <= 2) continue;
    sides[edge] = faces.size();
    for (const std::size_t f : faces) patches[sets.root(f)].branches.push_back(edge);
  }
  std::vector<std::size_t> order;
  for (const auto& [root, patch] : patches) {
    if (!patch.branches.empty()) order.push_back(root);
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t i, std::size_t j) { return patches[i].area < patches[j].area; });
  std::map<std::size_t, bool> gone;
  for (const std::size_t root : order) {
    const Patch& patch = patches[root];
    const auto is_branch = [&](const Edge& e) { return sides[e] > 2; };
    const bool fin = patch.open > 0 && patch.area <= small * area &&
                     std::any_of(patch.branches.begin(), patch.branches.end(), is_branch);
    // Without a wall two faces are left at each edge of its rim.
    const bool wall =
        patch.open == 0 && patch.area < area / 3 &&
        std::all_of(patch.branches.begin(), patch.branches.end(), [&](const Edge& e) { return sides[e] == 3; });
    if (!fin && !wall) continue;
    gone[root] = true;
    for (const Edge& e : patch.branches) --sides[e];
  }
  std::vector<bool> drop(soup.polygons.size(), false);
  std::size_t count = 0;
  for (std::size_t f = 0; f < soup.polygons.size(); ++f) {
    if (!gone.contains(sets.root(f))) continue;
    drop[f] = true;
    removed.push_back(soup.numbers[f]);
    ++count;
  }
  remove_polygons(soup, drop);
  return count;
}

}  // namespace

double area_of(const NumberedSoup& soup, std::size_t polygon) {
  const auto& p = soup.polygons[polygon];
  Vec3 sum;
  for (std::size_t k = 2; k < p.size(); ++k) {
    sum = sum + cross(soup.points[p[k - 1]] - soup.points[p[0]], soup.points[p[k]] - soup.points[p[0]]);
  }
  return 0.5 * norm(sum);
}

std::size_t merge_rims(NumberedSoup& soup, double reach) {
  const std::vector<std::size_t> rim = rim_points(soup);
  std::vector<std::size_t> now(soup.points.size());
  std::iota(now.begin(), now.end(), std::size_t{0});
  PointTree stay(soup);
  std::size_t merged = 0;
  for (const std::size_t i : rim) {
    // To the nearest of those that stay, so that nothing wanders along a chain of near points.
    std::pair best{reach, i};
    stay.for_each_near(soup.points[i], soup.points[i], reach, [&](std::size_t j) {
      const double d = norm(soup.points[i] - soup.points[j]);
      if (d < reach) best = std::min(best, {d, j});
    });
    now[i] = best.second;
    if (now[i] == i) {
      stay.insert(i);
    } else {
      ++merged;
    }
  }
  for (auto& polygon : soup.polygons) {
    for (std::size_t& corner : polygon) corner = now[corner];
  }
  drop_collapsed(soup);
  return merged;
}

std::size_t cut_at_rims(NumberedSoup& soup, double reach) {
  PointTree rim(soup);
  for (const std::size_t i : rim_points(soup)) rim.insert(i);
  std::size_t cuts = 0;
  std::vector<std::pair<Edge, std::size_t>> open;
  for (const auto& [edge, faces] : faces_at_edges(soup)) {
    if (faces.size() == 1) open.emplace_back(edge, faces[0]);
  }
  std::vector<bool> changed(soup.polygons.size(), false);
  for (const auto& [edge, face] : open) {
    if (changed[face]) continue;  // in the next round
    const Vec3 a = soup.points[edge.first], b = soup.points[edge.second];
    const double length = norm(b - a);
    const std::size_t none = soup.points.size();
    std::pair nearest{reach, none};
    rim.for_each_near(a, b, reach, [&](std::size_t i) {
      const double t = dot(soup.points[i] - a, b - a) / (length * length);
      const double beside = norm(soup.points[i] - (a + t * (b - a)));
      if (t * length > reach && (1 - t) * length > reach) nearest = std::min(nearest, {beside, i});
    });
    const std::size_t best = nearest.second;
    const auto& p = soup.polygons[face];
    if (best == none || std::find(p.begin(), p.end(), best) != p.end()) continue;
    std::size_t k = 0;
    while (edge_of(p[k], p[(k + 1) % 3]) != edge) ++k;
    const std::vector<std::size_t> first{p[k], best, p[(k + 2) % 3]}, second{best, p[(k + 1) % 3], p[(k + 2) % 3]};
    changed[face] = true;
    soup.polygons[face] = first;
    soup.polygons.push_back(second);
    soup.numbers.push_back(soup.numbers[face]);
    ++cuts;
  }
  return cuts;
}

std::size_t remove_fins(NumberedSoup& soup, std::vector<std::size_t>& removed) {
  std::size_t total = 0;
  for (int round = 0; round < 10; ++round) {
    const std::size_t gone = remove_fins_once(soup, removed);
    if (gone == 0) break;
    total += gone;
  }
  return total;
}

}  // namespace tactor
