#include "nodes/physics/contact/soft_surface.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

constexpr std::size_t leaf_faces = 4;

/// num / den in 0 to 1, and 0 where there is no length to divide.
double part_of(double num, double den) {
  return den > 0 ? std::clamp(num / den, 0.0, 1.0) : 0;
}

OnFace at_shares(const std::array<const Vec3*, 3>& corner, const std::array<double, 3>& share, const Vec3& x,
                 Feature feature, std::uint8_t i) {
  const Vec3 p = share[0] * *corner[0] + share[1] * *corner[1] + share[2] * *corner[2];
  return {share, p, dot(x - p, x - p), feature, i};
}

OnFace on_corner(const std::array<const Vec3*, 3>& corner, const Vec3& x, std::uint8_t i) {
  std::array<double, 3> share{};
  share[i] = 1;
  return at_shares(corner, share, x, Feature::corner, i);
}

/// At t of edge i, from its beginning (0) to its end (1).
OnFace on_edge(const std::array<const Vec3*, 3>& corner, const Vec3& x, std::uint8_t i, double t) {
  const auto next = static_cast<std::uint8_t>((i + 1) % 3);
  if (!(t > 0)) return on_corner(corner, x, i);
  if (!(t < 1)) return on_corner(corner, x, next);
  std::array<double, 3> share{};
  share[i] = 1 - t;
  share[next] = t;
  return at_shares(corner, share, x, Feature::edge, i);
}

/// The nearest of the three edges, of a face that has no area.
OnFace on_edges(const std::array<const Vec3*, 3>& corner, const Vec3& x) {
  OnFace best;
  best.squared = std::numeric_limits<double>::infinity();
  for (std::uint8_t i = 0; i < 3; ++i) {
    const Vec3 &from = *corner[i], along = *corner[(i + 1U) % 3] - from;
    const OnFace on = on_edge(corner, x, i, part_of(dot(x - from, along), dot(along, along)));
    if (on.squared < best.squared) best = on;
  }
  return best;
}

/// v of length 1, or zero where it has no direction.
Vec3 direction(const Vec3& v) {
  const double length = norm(v);
  return length > 0 && std::isfinite(length) ? v / length : Vec3{};
}

}  // namespace

/// By the regions of C. Ericson, "Real-Time Collision Detection", section 5.1.5.
OnFace nearest_on_face(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& x) {
  const std::array<const Vec3*, 3> corner{&a, &b, &c};
  const Vec3 ab = b - a, ac = c - a, ax = x - a, bx = x - b, cx = x - c;
  const double d1 = dot(ab, ax), d2 = dot(ac, ax), d3 = dot(ab, bx), d4 = dot(ac, bx), d5 = dot(ab, cx),
               d6 = dot(ac, cx);
  if (d1 <= 0 && d2 <= 0) return on_corner(corner, x, 0);
  if (d3 >= 0 && d4 <= d3) return on_corner(corner, x, 1);
  if (d6 >= 0 && d5 <= d6) return on_corner(corner, x, 2);
  const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
  // Rounding in va, vb and vc decides where they are as small as that.
  const double sum = va + vb + vc, least = 1e-14 * dot(ab, ab) * dot(ac, ac);
  if (!(sum > least)) return on_edges(corner, x);
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return on_edge(corner, x, 0, part_of(d1, d1 - d3));
  if (va <= 0 && d4 >= d3 && d5 >= d6) return on_edge(corner, x, 1, part_of(d4 - d3, (d4 - d3) + (d5 - d6)));
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return on_edge(corner, x, 2, 1 - part_of(d2, d2 - d6));
  const double v = vb / sum, w = vc / sum;
  return at_shares(corner, {1 - v - w, v, w}, x, Feature::face, 0);
}

void MovingSurface::reserve(std::size_t faces, std::size_t nodes) {
  faces_.reserve(faces);
  order_.reserve(faces);
  tree_.reserve(2 * faces);
  neighbour_.reserve(faces);
  around_.reserve(3 * faces);
  around_begin_.reserve(nodes + 1);
  at_rim_.reserve(nodes);
  were_.reserve(nodes);
}

Vec3 MovingSurface::middle(std::int32_t face) const {
  return (corner(face, 0) + corner(face, 1) + corner(face, 2)) / 3.0;
}

Vec3 MovingSurface::normal(std::int32_t face) const {
  const Vec3& a = corner(face, 0);
  return direction(cross(corner(face, 1) - a, corner(face, 2) - a));
}

void MovingSurface::set(std::span<const FaceNodes> faces, std::span<const Vec3> nodes) {
  for (const FaceNodes& face : faces) {
    for (const std::int32_t i : face) TACTOR_DEMAND(i >= 0 && static_cast<std::size_t>(i) < nodes.size());
  }
  faces_.assign(faces.begin(), faces.end());
  nodes_ = nodes;
  connect(nodes.size());
  order_.resize(faces_.size());
  std::iota(order_.begin(), order_.end(), 0);
  tree_.clear();
  tree_.reserve(2 * faces_.size());
  if (!faces_.empty()) build(0, faces_.size());
  ++times_placed_;
  were_.assign(nodes.begin(), nodes.end());
  move(nodes);
}

/// Who is whose neighbour, and where the surface ends.
void MovingSurface::connect(std::size_t nodes) {
  around_begin_.assign(nodes + 1, 0);
  around_.resize(3 * faces_.size());
  at_rim_.assign(nodes, 0);
  open_ = false;
  for (const FaceNodes& face : faces_) {
    for (const std::int32_t i : face) ++around_begin_[static_cast<std::size_t>(i)];
  }
  std::partial_sum(around_begin_.begin(), around_begin_.end(), around_begin_.begin());
  // From behind, so that each one's begin ends where it has to be.
  for (std::size_t k = faces_.size(); k-- > 0;) {
    for (const std::int32_t i : faces_[k]) {
      around_[static_cast<std::size_t>(--around_begin_[static_cast<std::size_t>(i)])] = static_cast<std::int32_t>(k);
    }
  }
  neighbour_.assign(faces_.size(), {-1, -1, -1});
  for (std::size_t k = 0; k < faces_.size(); ++k) {
    for (std::size_t e = 0; e < 3; ++e) {
      const std::int32_t from = faces_[k][e], to = faces_[k][(e + 1) % 3];
      const auto begin = static_cast<std::size_t>(around_begin_[static_cast<std::size_t>(from)]),
                 end = static_cast<std::size_t>(around_begin_[static_cast<std::size_t>(from) + 1]);
      for (std::size_t j = begin; j < end; ++j) {
        const std::int32_t other = around_[j];
        if (static_cast<std::size_t>(other) == k) continue;
        const FaceNodes& f = faces_[static_cast<std::size_t>(other)];
        if (std::find(f.begin(), f.end(), to) == f.end()) continue;
        neighbour_[k][e] = other;
        break;
      }
      if (neighbour_[k][e] >= 0) continue;
      open_ = true;
      at_rim_[static_cast<std::size_t>(from)] = at_rim_[static_cast<std::size_t>(to)] = 1;
    }
  }
}

void MovingSurface::build(std::size_t begin, std::size_t end) {
  const std::size_t index = tree_.size();
  tree_.push_back({});
  if (end - begin <= leaf_faces) {
    tree_[index].first = static_cast<std::int32_t>(begin);
    tree_[index].count = static_cast<std::int32_t>(end - begin);
    return;
  }
  Bounds middles;
  for (std::size_t i = begin; i < end; ++i) middles.add(middle(order_[i]));
  const int axis = middles.longest_axis();
  const auto at = [&](std::size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
  // Not numbers are ordered among themselves by the faces, after all others.
  const auto place = [&](std::int32_t face) {
    const double m = middle(face)[axis];
    return std::isnan(m) ? std::numeric_limits<double>::infinity() : m;
  };
  const std::size_t half = begin + (end - begin) / 2;
  std::nth_element(at(begin), at(half), at(end), [&](std::int32_t a, std::int32_t b) {
    const double ma = place(a), mb = place(b);
    return ma != mb ? ma < mb : a < b;
  });
  build(begin, half);
  tree_[index].right = static_cast<std::int32_t>(tree_.size());
  build(half, end);
}

void MovingSurface::move(std::span<const Vec3> nodes) {
  TACTOR_DEMAND(nodes.size() + 1 == around_begin_.size());
  nodes_ = nodes;
  double longest = 0;
  bool is_known = true;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const Vec3 way = nodes[i] - were_[i];
    const double squared = dot(way, way);
    is_known = is_known && std::isfinite(squared);
    longest = std::max(longest, squared);
    were_[i] = nodes[i];
  }
  if (is_known) {
    way_ += std::sqrt(longest);
  } else {
    ++times_placed_;
  }
  for (std::size_t k = tree_.size(); k-- > 0;) {
    Node& node = tree_[k];
    node.box = {};
    if (node.count == 0) {
      for (const Node* child : {&tree_[k + 1], &tree_[static_cast<std::size_t>(node.right)]}) {
        node.box.add(child->box.low);
        node.box.add(child->box.high);
      }
      continue;
    }
    for (std::int32_t j = node.first; j < node.first + node.count; ++j) {
      const std::int32_t face = order_[static_cast<std::size_t>(j)];
      for (std::size_t i = 0; i < 3; ++i) node.box.add(corner(face, i));
    }
  }
}

/// N of the face, edge or corner; zero where it has none.
Vec3 MovingSurface::normal_of(std::int32_t face, const OnFace& on) const {
  if (on.feature == Feature::face) return normal(face);
  if (on.feature == Feature::edge) {
    const std::int32_t other = neighbour_[static_cast<std::size_t>(face)][on.i];
    return direction(normal(face) + (other < 0 ? Vec3{} : normal(other)));
  }
  const std::int32_t node = faces_[static_cast<std::size_t>(face)][on.i];
  const auto begin = static_cast<std::size_t>(around_begin_[static_cast<std::size_t>(node)]),
             end = static_cast<std::size_t>(around_begin_[static_cast<std::size_t>(node) + 1]);
  Vec3 sum;
  for (std::size_t j = begin; j < end; ++j) {
    const FaceNodes& f = faces_[static_cast<std::size_t>(around_[j])];
    const auto i = static_cast<std::size_t>(std::find(f.begin(), f.end(), node) - f.begin());
    const Vec3& at = corner(around_[j], i);
    const Vec3 u = direction(corner(around_[j], (i + 1) % 3) - at), v = direction(corner(around_[j], (i + 2) % 3) - at);
    sum += std::acos(std::clamp(dot(u, v), -1.0, 1.0)) * normal(around_[j]);
  }
  return direction(sum);
}

bool MovingSurface::ends_at(std::int32_t face, const OnFace& on) const {
  if (on.feature == Feature::face) return false;
  if (on.feature == Feature::edge) return neighbour_[static_cast<std::size_t>(face)][on.i] < 0;
  return at_rim_[static_cast<std::size_t>(faces_[static_cast<std::size_t>(face)][on.i])] != 0;
}

SurfacePoint MovingSurface::nearest(const Vec3& x, std::int32_t hint, int* left) const {
  constexpr double infinity_squared = std::numeric_limits<double>::infinity();
  OnFace best;
  best.squared = infinity_squared;
  std::int32_t best_face = -1;
  const auto look_at = [&](std::int32_t face) {
    const OnFace on = nearest_on_face(corner(face, 0), corner(face, 1), corner(face, 2), x);
    if (on.squared < best.squared || (on.squared == best.squared && face < best_face)) best = on, best_face = face;
  };
  if (hint >= 0 && static_cast<std::size_t>(hint) < faces_.size()) look_at(hint);
  struct Open {
    double squared;
    std::int32_t node;
  };
  std::array<Open, most_levels> open;
  std::size_t count = 0;
  if (!tree_.empty()) open[count++] = {0, 0};
  while (count > 0) {
    const Open next = open[--count];
    // A little less than the box's, so that of faces as near none is passed over by rounding.
    if (!(next.squared * (1 - 1e-12) <= best.squared)) continue;
    const Node& node = tree_[static_cast<std::size_t>(next.node)];
    if (node.count > 0) {
      for (std::int32_t j = node.first; j < node.first + node.count; ++j) look_at(order_[static_cast<std::size_t>(j)]);
      if (left != nullptr) --*left;
      continue;
    }
    Open one{0, next.node + 1}, other{0, node.right};
    one.squared = squared_to_box(tree_[static_cast<std::size_t>(one.node)].box, x);
    other.squared = squared_to_box(tree_[static_cast<std::size_t>(other.node)].box, x);
    // The nearer comes on top.
    if (one.squared < other.squared) std::swap(one, other);
    open[count++] = one;
    open[count++] = other;
  }
  SurfacePoint point;
  point.distance = infinity_squared;
  if (best_face < 0 || !std::isfinite(best.squared)) return point;
  const Vec3 n = normal_of(best_face, best), away = x - best.p;
  const double length = std::sqrt(best.squared), sign = dot(away, n) < 0 ? -1 : 1;
  // Nearer than rounding to the surface, the difference has no direction.
  const bool on_surface = length < 1e-12;
  point.distance = sign * length;
  point.n = on_surface ? n : away * (sign / length);
  point.p = best.p;
  point.face = best_face;
  point.share = best.share;
  const bool too_deep = open_ && point.distance < -norm(box().size());
  point.judged = n != Vec3{} && !ends_at(best_face, best) && !too_deep;
  return point;
}

Vec3 MovingSurface::mean_normal(const SurfacePoint& at, double radius, std::vector<std::int32_t>& scratch,
                                int* left) const {
  Bounds about;
  about.add(at.p);
  faces_in(larger(about, radius), scratch);
  Vec3 sum;
  for (const std::int32_t face : scratch) {
    if (left != nullptr) --*left;
    const Vec3 &a = corner(face, 0), &b = corner(face, 1), &c = corner(face, 2);
    const double inside = 1 - nearest_on_face(a, b, c, at.p).squared / (radius * radius);
    if (!(inside > 0)) continue;
    const Vec3 across = cross(b - a, c - a);
    const double doubled = norm(across);
    if (!(doubled > 0)) continue;
    const Vec3 n = across / doubled;
    const double towards = std::clamp(1 + 2 * dot(n, at.n), 0.0, 1.0);
    sum += inside * inside * std::min(0.5 * doubled, radius * radius) * towards * n;
  }
  const Vec3 mean = direction(sum);
  return dot(mean, at.n) > 0.2 ? mean : at.n;
}

}  // namespace tactor
