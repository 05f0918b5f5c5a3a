#include "nodes/physics/geometry/sample_tree.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "framework/core/check.hpp"
#include "nodes/physics/geometry/outward.hpp"
#include "nodes/physics/geometry/wide.hpp"
#include "nodes/physics/mesh/bounds.hpp"

namespace tactor {

namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr std::size_t nodes_a_step = 8;  // whose expiries are written anew

/// A pose in floats.
struct FloatPose {
  std::array<std::array<float, 3>, 3> R;
  std::array<float, 3> p;
};

FloatPose float_pose(const Pose& X) {
  FloatPose pose;
  const Vec3 column[3] = {rotate(X.R, {1, 0, 0}), rotate(X.R, {0, 1, 0}), rotate(X.R, {0, 0, 1})};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) pose.R[i][j] = static_cast<float>(column[j][static_cast<int>(i)]);
    pose.p[i] = static_cast<float>(X.p[static_cast<int>(i)]);
  }
  return pose;
}

}  // namespace

struct SampleTree::Query {
  const SignedDistance& other;
  const Pose& X_OB;
  FloatPose pose;
  double margin;      // m
  float taken;        // m, margin and what rounding may add, rounded up
  float way, turn;    // m and rad, rounded up
  float look_closer;  // m, a sample that is out of reach by less is measured exactly
  int* left;          // steps of work, or null
  [[nodiscard]] bool over() const { return left != nullptr && *left < 0; }
  void work() const {
    if (left != nullptr) --*left;
  }
};

SampleTree::SampleTree(const std::vector<SurfaceSample>& samples, const std::vector<double>& radii) {
  TACTOR_DEMAND(radii.empty() || radii.size() == samples.size());
  if (samples.empty()) return;
  Bounds all;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples_.push_back({samples[i].p, radii.empty() ? 0 : radii[i]});
    all.add(samples[i].p);
  }
  pivot_ = all.middle();
  std::vector<int> order(samples.size());
  std::iota(order.begin(), order.end(), 0);
  build(order, 0, order.size());
  for (const float lever : nodes_.front().lever) size_ = std::max<double>(size_, lever);
  found_.reserve(std::min<std::size_t>(samples.size(), 1024));
}

/// A node over the samples from begin to end.
std::int32_t SampleTree::build(std::vector<int>& order, std::size_t begin, std::size_t end) {
  const auto at = [&](std::size_t i) -> const Sample& { return samples_[static_cast<std::size_t>(order[i])]; };
  const std::size_t index = nodes_.size();
  nodes_.push_back({});
  // Every child but the last holds as many samples as a full tree of one level less.
  std::size_t full = 1;
  while (8 * full < end - begin) full *= 8;
  const auto bounds = [&](std::size_t from, std::size_t to) {
    Bounds b;
    for (std::size_t i = from; i < to; ++i) b.add(at(i).p);
    return b;
  };
  const auto split = [&](auto&& self, std::size_t from, std::size_t to) -> void {
    if (to - from <= full) return;
    const int axis = bounds(from, to).longest_axis();
    const std::size_t middle = from + (to - from + full - 1) / full / 2 * full;
    const auto place = [&](std::size_t i) { return order.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(place(from), place(middle), place(to), [&](int a, int b) {
      const Vec3 &pa = samples_[static_cast<std::size_t>(a)].p, &pb = samples_[static_cast<std::size_t>(b)].p;
      return pa[axis] != pb[axis] ? pa[axis] < pb[axis] : a < b;
    });
    self(self, from, middle);
    self(self, middle, to);
  };
  split(split, begin, end);

  Node node;
  for (std::size_t k = 0; k < 8; ++k) {
    const std::size_t from = std::min(begin + k * full, end), to = std::min(from + full, end);
    node.x[k] = node.y[k] = node.z[k] = node.radius[k] = node.lever[k] = 0;
    node.expiry[k] = from == to ? infinity : -infinity;
    node.child[k] = 0;
    if (from == to) continue;
    const Vec3 middle = bounds(from, to).middle();
    node.x[k] = static_cast<float>(middle.x);
    node.y[k] = static_cast<float>(middle.y);
    node.z[k] = static_cast<float>(middle.z);
    const Vec3 centre{node.x[k], node.y[k], node.z[k]};
    double radius = 0;
    for (std::size_t i = from; i < to; ++i) radius = std::max(radius, norm(at(i).p - centre) + at(i).radius);
    node.radius[k] = rounded_up(radius);
    node.lever[k] = rounded_up(norm(centre - pivot_));
    if (full == 1) {
      node.child[k] = ~order[from];
    } else {
      node.child[k] = build(order, from, to);
      for (const float lever : nodes_[static_cast<std::size_t>(node.child[k])].lever) {
        node.lever[k] = std::max(node.lever[k], lever);
      }
    }
  }
  nodes_[index] = node;
  return static_cast<std::int32_t>(index);
}

void SampleTree::forget() {
  for (Node& node : nodes_) {
    for (float& expiry : node.expiry) {
      if (expiry < infinity) expiry = -infinity;
    }
  }
  way_ = turn_ = 0;
}

/// Adds the way from the last pose to this one. True where it has written all expiries anew.
bool SampleTree::advance(const Pose& X_OB) {
  // An expiry that is no number would never come.
  TACTOR_DEMAND(is_finite(X_OB.p) && std::isfinite(X_OB.R.w + X_OB.R.x + X_OB.R.y + X_OB.R.z));
  way_ += norm(transform(X_OB, pivot_) - transform(*last_pose_, pivot_));
  const Quat turned = inverse(last_pose_->R) * X_OB.R;
  turn_ += 2 * norm({turned.x, turned.y, turned.z});
  // Where the ways have grown long, floats would lose the small differences.
  if (way_ + turn_ * size_ < 2 * size_) return false;
  for (Node& node : nodes_) {
    for (std::size_t k = 0; k < 8; ++k) {
      node.expiry[k] = rounded_down(node.expiry[k] - (way_ + turn_ * node.lever[k]));
    }
  }
  way_ = turn_ = 0;
  return true;
}

TACTOR_WIDE unsigned SampleTree::expired(const Node& node, float way, float turn) {
  const wide::F8 reached = way + turn * wide::load(node.lever.data());
  return wide::mask_of(wide::load(node.expiry.data()) <= reached);
}

TACTOR_WIDE void SampleTree::place(const Node& node, const Query& query, Points8& x) {
  const wide::F8 px = wide::load(node.x.data()), py = wide::load(node.y.data()), pz = wide::load(node.z.data());
  const auto& R = query.pose.R;
  const auto& p = query.pose.p;
  wide::store(x.x.data(), R[0][0] * px + R[0][1] * py + R[0][2] * pz + p[0]);
  wide::store(x.y.data(), R[1][0] * px + R[1][1] * py + R[1][2] * pz + p[1]);
  wide::store(x.z.data(), R[2][0] * px + R[2][1] * py + R[2][2] * pz + p[2]);
}

/// Finds the samples below the node and returns the least expiry of its children.
float SampleTree::visit(Node& node, const Query& query) {
  const unsigned open = expired(node, query.way, query.turn);
  if (open != 0 && !query.over()) {
    query.work();
    Points8 x;
    place(node, query, x);
    std::array<float, 8> bound;
    for (const std::int32_t child : node.child) {
      if (child < 0) __builtin_prefetch(&samples_[static_cast<std::size_t>(~child)]);
    }
    query.other.lower_bounds(x, open, bound);
    for (std::size_t k = 0; k < 8; ++k) {
      // What is not looked at stays as due as it is.
      if ((open >> k & 1) == 0 || query.over()) continue;
      const float reached = query.way + query.turn * node.lever[k];
      float spare = bound[k] - node.radius[k] - query.taken;
      if (node.child[k] >= 0) {
        node.expiry[k] = spare > 0 ? reached + spare : visit(nodes_[static_cast<std::size_t>(node.child[k])], query);
        continue;
      }
      if (spare <= query.look_closer) {
        query.work();
        const std::int32_t index = ~node.child[k];
        Sample& sample = samples_[static_cast<std::size_t>(index)];
        const Nearest nearest = query.other.nearest(transform(query.X_OB, sample.p), sample.face);
        sample.face = nearest.face;
        const double distance = nearest.distance - sample.radius;
        if (distance < query.margin) {
          found_.push_back({index, distance, nearest});
          spare = -infinity;
        } else {
          spare = static_cast<float>(distance) - query.taken;
        }
      }
      node.expiry[k] = reached + spare;
    }
  }
  float least = infinity;
  for (const float expiry : node.expiry) least = std::min(least, expiry);
  return least;
}

std::size_t SampleTree::reserve_within(int work) {
  // Each sample that is found took a step; the last one may be that which was too many.
  const std::size_t most = std::min(samples_.size(), static_cast<std::size_t>(work) + 1);
  found_.reserve(most);
  return most;
}

const std::vector<NearSample>& SampleTree::find(const SignedDistance& other, const Pose& X_OB, double margin,
                                                int* left) {
  if (nodes_.empty() || (complete_ && last_pose_ == X_OB && last_margin_ == margin)) return found_;
  const double before = way_ + turn_ * size_;
  double moved = 0;
  bool all_written = false;
  if (last_pose_ && last_margin_ != margin) {
    forget();
    all_written = true;
  } else if (last_pose_) {
    all_written = advance(X_OB);
    moved = std::max(0.0, way_ + turn_ * size_ - before);
  }
  if (left != nullptr && all_written) {
    const auto steps = static_cast<int>((nodes_.size() + nodes_a_step - 1) / nodes_a_step);
    *left = std::max(*left - steps, -1);
  }
  last_pose_ = X_OB;
  last_margin_ = margin;
  found_.clear();
  // Floats hold positions to 2^-24 of their size, over a few operations.
  const double rounding = std::ldexp(norm(X_OB.p) + norm(pivot_) + 4 * size_, -20);
  const Query query{.other = other,
                    .X_OB = X_OB,
                    .pose = float_pose(X_OB),
                    .margin = margin,
                    .taken = rounded_up(margin + rounding),
                    .way = rounded_up(way_),
                    .turn = rounded_up(turn_),
                    .look_closer = static_cast<float>(4 * moved),
                    .left = left};
  visit(nodes_.front(), query);
  complete_ = !query.over();
  return found_;
}

}  // namespace tactor
