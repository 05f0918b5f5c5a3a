#include "nodes/physics/geometry/face_tree.hpp"

#include <algorithm>
#include <numeric>

#include "nodes/physics/geometry/outward.hpp"
#include "nodes/physics/geometry/wide.hpp"
#include "nodes/physics/mesh/bounds.hpp"

namespace tactor {

namespace {

using wide::F8;

constexpr float far_away = std::numeric_limits<float>::infinity();

/// The squared distances of x to the boxes of a node.
TACTOR_INLINE F8 squared_to_boxes(const FaceTree::Node& node, const float* x) {
  F8 sum = wide::all(0);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const F8 below = wide::load(node.low[axis].data()) - x[axis], above = x[axis] - wide::load(node.high[axis].data());
    const F8 apart = wide::max(wide::max(below, above), wide::all(0));
    sum += apart * apart;
  }
  return sum;
}

struct Open {
  float squared;
  std::int32_t child;
};

constexpr std::size_t most_open = 8 * FaceTree::most_levels;

TACTOR_WIDE void search_tree(const FaceTree& tree, wide::Search& search) {
  const float x[3] = {search.fx, search.fy, search.fz};
  std::array<Open, most_open> open;
  std::size_t count = 0;
  open[count++] = {0, 0};
  while (count > 0) {
    const Open next = open[--count];
    if (!(next.squared <= search.limit)) continue;
    if (next.child < 0) {
      const FaceRecord* face[8];
      for (std::int32_t k = 0; k < 8; ++k) face[k] = &tree.records[static_cast<std::size_t>(~next.child + k)];
      search.consider(face);
      continue;
    }
    const FaceTree::Node& node = tree.nodes[static_cast<std::size_t>(next.child)];
    alignas(32) float squared[8];
    wide::store(squared, squared_to_boxes(node, x));
    // The nearest comes on top.
    const std::size_t bottom = count;
    for (std::size_t k = 0; k < 8; ++k) {
      if (!(squared[k] <= search.limit) || node.child[k] == FaceTree::no_child) continue;
      std::size_t at = count++;
      for (; at > bottom && open[at - 1].squared < squared[k]; --at) open[at] = open[at - 1];
      open[at] = {squared[k], node.child[k]};
    }
  }
}

}  // namespace

FaceTree::FaceTree(const Surface& surface) {
  Bounds bounds;
  for (const auto& corners : surface.corners) {
    for (const Vec3& c : corners) bounds.add(c);
  }
  origin = bounds.middle();
  reach = norm(bounds.high - origin);

  std::vector<int> order(surface.corners.size());
  std::iota(order.begin(), order.end(), 0);
  records.reserve(2 * order.size());
  build(surface, order, 0, order.size());
  // Far, but so that its square is a float.
  FaceRecord far{};
  far.a[0] = far.a[1] = far.a[2] = 1e18F;
  far.face = -1;
  records.push_back(far);
  for (FaceRecord& r : records) {
    if (r.face < 0) r = far;
  }
}

/// The faces from begin to end as a child: a node, or a leaf of eight records filled up with faces far away.
std::int32_t FaceTree::build(const Surface& surface, std::vector<int>& order, std::size_t begin, std::size_t end) {
  const auto middle_of = [&](int face) {
    const auto& c = surface.corners[static_cast<std::size_t>(face)];
    return (c[0] + c[1] + c[2]) / 3.0;
  };
  const bool is_root = nodes.empty();
  if (end - begin <= 8 && !is_root) {
    const auto first = static_cast<std::int32_t>(records.size());
    for (std::size_t k = 0; k < 8; ++k) {
      records.push_back(begin + k < end ? record(surface, order[begin + k]) : FaceRecord{.face = -1});
    }
    return ~first;
  }
  const std::size_t index = nodes.size();
  nodes.push_back({});
  // Every child but the last holds as many faces as a full tree of one level less.
  std::size_t full = 8;
  while (8 * full < end - begin) full *= 8;
  const auto split = [&](auto&& self, std::size_t from, std::size_t to) -> void {
    if (to - from <= full) return;
    Bounds middles;
    for (std::size_t i = from; i < to; ++i) middles.add(middle_of(order[i]));
    const int axis = middles.longest_axis();
    const std::size_t parts = (to - from + full - 1) / full;
    const std::size_t middle = from + parts / 2 * full;
    const auto place = [&](std::size_t i) { return order.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(place(from), place(middle), place(to), [&](int a, int b) {
      const double ma = middle_of(a)[axis], mb = middle_of(b)[axis];
      return ma != mb ? ma < mb : a < b;
    });
    self(self, from, middle);
    self(self, middle, to);
  };
  split(split, begin, end);

  Node node;
  for (std::size_t k = 0; k < 8; ++k) {
    const std::size_t from = std::min(begin + k * full, end), to = std::min(from + full, end);
    for (std::size_t axis = 0; axis < 3; ++axis) node.low[axis][k] = far_away, node.high[axis][k] = -far_away;
    node.child[k] = no_child;
    if (from == to) continue;
    for (std::size_t i = from; i < to; ++i) {
      for (const Vec3& c : surface.corners[static_cast<std::size_t>(order[i])]) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const double v = c[static_cast<int>(axis)] - origin[static_cast<int>(axis)];
          node.low[axis][k] = std::min(node.low[axis][k], rounded_down(v));
          node.high[axis][k] = std::max(node.high[axis][k], rounded_up(v));
        }
      }
    }
    node.child[k] = build(surface, order, from, to);
  }
  nodes[index] = node;
  return static_cast<std::int32_t>(index);
}

FaceRecord FaceTree::record(const Surface& surface, int face) const {
  const auto& corners = surface.corners[static_cast<std::size_t>(face)];
  // Corner a is opposite to the longest edge.
  std::size_t widest = 0;
  double longest = -1;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 opposite = corners[(i + 2) % 3] - corners[(i + 1) % 3];
    if (dot(opposite, opposite) > longest) longest = dot(opposite, opposite), widest = i;
  }
  const Vec3 a = corners[widest] - origin;
  const Vec3 ab = corners[(widest + 1) % 3] - corners[widest], ac = corners[(widest + 2) % 3] - corners[widest];
  const double bb = dot(ab, ab), cc = dot(ac, ac), bc = dot(ab, ac);
  const Vec3 n = cross(ab, ac);
  const double nn = dot(n, n);
  const auto f = [](double v) { return static_cast<float>(v); };
  FaceRecord r{{f(a.x), f(a.y), f(a.z)},
               face,
               {f(ab.x), f(ab.y), f(ab.z)},
               f(1 / bb),
               {f(ac.x), f(ac.y), f(ac.z)},
               f(1 / cc),
               f(cc / nn),
               f(bc / nn),
               f(bb / nn),
               f(1 / longest)};
  if (nn < 0.25 * bb * cc) r.a[0] = std::numeric_limits<float>::quiet_NaN();
  return r;
}

NearestFace FaceTree::nearest(const Surface& surface, const Vec3& x, int hint) const {
  wide::Search s = wide::search_about(*this, surface, x);
  s.look_at(hint >= 0 ? hint : records.front().face);
  search_tree(*this, s);
  return s.best;
}

namespace {

TACTOR_WIDE void collect(const FaceTree& tree, const float* x, float limit, std::vector<std::uint32_t>& found) {
  std::array<std::int32_t, most_open> open;
  std::size_t count = 0;
  open[count++] = 0;
  while (count > 0) {
    const std::int32_t next = open[--count];
    alignas(32) float squared[8];
    if (next < 0) {
      const FaceRecord* face[8];
      for (std::int32_t k = 0; k < 8; ++k) face[k] = &tree.records[static_cast<std::size_t>(~next + k)];
      wide::store(squared, wide::squared_distances(face, x[0], x[1], x[2]));
      for (std::int32_t k = 0; k < 8; ++k) {
        if (squared[k] <= limit && face[k]->face >= 0) found.push_back(static_cast<std::uint32_t>(~next + k));
      }
      continue;
    }
    const FaceTree::Node& node = tree.nodes[static_cast<std::size_t>(next)];
    wide::store(squared, squared_to_boxes(node, x));
    for (std::size_t k = 0; k < 8; ++k) {
      if (squared[k] <= limit && node.child[k] != FaceTree::no_child) open[count++] = node.child[k];
    }
  }
}

}  // namespace

void FaceTree::within(const Vec3& x, double reach_of_x, std::vector<std::uint32_t>& found) const {
  const Vec3 about = x - origin;
  const float local[3] = {static_cast<float>(about.x), static_cast<float>(about.y), static_cast<float>(about.z)};
  const double far = reach_of_x + error(x);
  found.clear();
  collect(*this, local, static_cast<float>(1.000001 * far * far), found);
}

}  // namespace tactor
