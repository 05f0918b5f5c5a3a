#include "nodes/physics/mesh/soup_topology.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

#include "framework/core/check.hpp"
#include "nodes/physics/mesh/disjoint_sets.hpp"

namespace tactor {

namespace {

using Polygon = std::vector<std::size_t>;
constexpr std::size_t none = std::numeric_limits<std::size_t>::max();

/// Of each used point, the first that is at the same place; `none` of the others.
std::vector<std::size_t> first_at_place(const std::vector<Vec3>& points, const std::vector<bool>& used) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (used[i]) order.push_back(i);
  }
  std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) {
    const Vec3 &p = points[i], &q = points[j];
    return std::tie(p.x, p.y, p.z, i) < std::tie(q.x, q.y, q.z, j);
  });
  std::vector<std::size_t> first(points.size(), none);
  for (std::size_t k = 0; k < order.size(); ++k) {
    const bool same = k > 0 && points[order[k]] == points[order[k - 1]];
    first[order[k]] = same ? first[order[k - 1]] : order[k];
  }
  return first;
}

void merge_points(PolygonSoup& soup, MeshReport& report) {
  std::vector<bool> used(soup.points.size(), false);
  for (const Polygon& polygon : soup.polygons) {
    for (const std::size_t corner : polygon) used[corner] = true;
  }
  const std::vector<std::size_t> first = first_at_place(soup.points, used);
  std::vector<std::size_t> place(soup.points.size(), none);
  std::vector<Vec3> kept;
  std::size_t isolated = 0, merged = 0;
  for (std::size_t i = 0; i < soup.points.size(); ++i) {
    if (first[i] == none) {
      ++isolated;
    } else if (first[i] != i) {
      ++merged;
    } else {
      place[i] = kept.size();
      kept.push_back(soup.points[i]);
    }
  }
  for (Polygon& polygon : soup.polygons) {
    for (std::size_t& corner : polygon) corner = place[first[corner]];
  }
  soup.points = std::move(kept);
  if (isolated > 0) report.repairs.push_back(counted(isolated, "isolated vertex") + were(isolated) + "left out");
  if (merged > 0) report.repairs.push_back(counted(merged, "duplicated vertex") + were(merged) + "stitched");
}

void remove_repeated_corners(Polygon& polygon) {
  polygon.erase(std::unique(polygon.begin(), polygon.end()), polygon.end());
  while (polygon.size() > 1 && polygon.front() == polygon.back()) polygon.pop_back();
}

/// The same for polygons of the same corners in the same or in the reverse order, from whichever they begin.
Polygon canonical(const Polygon& polygon) {
  Polygon p = polygon;
  std::rotate(p.begin(), std::min_element(p.begin(), p.end()), p.end());
  if (p.size() > 2 && p.back() < p[1]) std::reverse(p.begin() + 1, p.end());
  return p;
}

/// True of each polygon that has the corners of an earlier one.
std::vector<bool> doubles(const std::vector<Polygon>& polygons) {
  std::vector<std::pair<Polygon, std::size_t>> sorted;
  sorted.reserve(polygons.size());
  for (std::size_t i = 0; i < polygons.size(); ++i) sorted.emplace_back(canonical(polygons[i]), i);
  std::sort(sorted.begin(), sorted.end());
  std::vector<bool> is_double(polygons.size(), false);
  for (std::size_t k = 1; k < sorted.size(); ++k) {
    if (sorted[k].first == sorted[k - 1].first) is_double[sorted[k].second] = true;
  }
  return is_double;
}

/// A polygon's side, with its ends in order of their numbers.
struct Side {
  std::size_t a, b;
  std::size_t polygon;
  std::size_t corner_a, corner_b;  // numbers of the corners in the whole soup
  bool forward;                    // the polygon goes from a to b
};

/// All sides, those of one edge side by side.
std::vector<Side> sides_of(const NumberedSoup& soup, const std::vector<bool>& ignored) {
  std::vector<Side> sides;
  std::size_t corners = 0;
  for (std::size_t i = 0; i < soup.polygons.size(); ++i) {
    const Polygon& p = soup.polygons[i];
    for (std::size_t k = 0; k < p.size() && !ignored[i]; ++k) {
      const std::size_t l = (k + 1) % p.size();
      if (p[k] < p[l]) {
        sides.push_back({p[k], p[l], i, corners + k, corners + l, true});
      } else {
        sides.push_back({p[l], p[k], i, corners + l, corners + k, false});
      }
    }
    corners += p.size();
  }
  std::sort(sides.begin(), sides.end(), [](const Side& s, const Side& t) {
    return std::tie(s.a, s.b, s.polygon, s.corner_a) < std::tie(t.a, t.b, t.polygon, t.corner_a);
  });
  return sides;
}

/// Calls `work(first, last)` for the sides of each edge.
template <class Work>
void for_each_edge(const std::vector<Side>& sides, const Work& work) {
  for (auto first = sides.begin(); first != sides.end();) {
    const auto last =
        std::find_if(first, sides.end(), [&](const Side& s) { return s.a != first->a || s.b != first->b; });
    work(first, last);
    first = last;
  }
}

}  // namespace

void remove_polygons(NumberedSoup& soup, const std::vector<bool>& drop) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < soup.polygons.size(); ++i) {
    if (drop[i]) continue;
    if (kept != i) soup.polygons[kept] = std::move(soup.polygons[i]);
    soup.numbers[kept++] = soup.numbers[i];
  }
  soup.polygons.resize(kept);
  soup.numbers.resize(kept);
}

NumberedSoup tidy(PolygonSoup soup, MeshReport& report) {
  merge_points(soup, report);
  NumberedSoup result{std::move(soup.points), std::move(soup.polygons), {}};
  result.numbers.resize(result.polygons.size());
  std::iota(result.numbers.begin(), result.numbers.end(), std::size_t{0});

  std::vector<bool> collapsed(result.polygons.size(), false);
  for (std::size_t i = 0; i < result.polygons.size(); ++i) {
    remove_repeated_corners(result.polygons[i]);
    collapsed[i] = result.polygons[i].size() < 3;
  }
  const auto told = [&](const std::vector<bool>& drop, const std::string& what) {
    const auto n = static_cast<std::size_t>(std::count(drop.begin(), drop.end(), true));
    if (n == 0) return;
    report.repairs.push_back(counted(n, what) + were(n) + "removed");
    remove_polygons(result, drop);
  };
  told(collapsed, "face without area");
  told(doubles(result.polygons), "duplicated face");
  return result;
}

EdgeFaults find_edge_faults(const NumberedSoup& soup, const std::vector<bool>& ignored) {
  EdgeFaults faults;
  bool first_is_branch = false;
  for_each_edge(sides_of(soup, ignored), [&](auto first, auto last) {
    const auto n = last - first;
    if (n == 2) {
      if (first->forward == (first + 1)->forward) ++faults.against;
      return;
    }
    const bool branch = n > 2;
    ++(branch ? faults.branches : faults.borders);
    if (faults.first && (first_is_branch || !branch)) return;
    first_is_branch = branch;
    faults.first = EdgeFaults::Edge{first->a, first->b, {}};
    for (auto side = first; side != last; ++side) faults.first->polygons.push_back(side->polygon);
  });
  return faults;
}

std::vector<std::size_t> find_bow_ties(const NumberedSoup& soup) {
  std::size_t corners = 0;
  for (const Polygon& polygon : soup.polygons) corners += polygon.size();
  DisjointSets fans(corners);
  for_each_edge(sides_of(soup, std::vector<bool>(soup.polygons.size(), false)), [&](auto first, auto last) {
    TACTOR_DEMAND(last - first == 2);
    const auto other = first + 1;
    fans.unite(first->corner_a, other->corner_a);
    fans.unite(first->corner_b, other->corner_b);
  });
  // A point whose corners make more than one fan is where parts touch.
  std::vector<std::size_t> fan_of(soup.points.size(), none);
  std::vector<bool> tied(soup.points.size(), false);
  std::size_t corner = 0;
  for (const Polygon& polygon : soup.polygons) {
    for (const std::size_t point : polygon) {
      const std::size_t fan = fans.root(corner++);
      if (fan_of[point] == none) fan_of[point] = fan;
      if (fan_of[point] != fan) tied[point] = true;
    }
  }
  std::vector<std::size_t> result;
  for (std::size_t i = 0; i < tied.size(); ++i) {
    if (tied[i]) result.push_back(i);
  }
  return result;
}

}  // namespace tactor
