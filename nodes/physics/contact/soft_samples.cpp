#include "nodes/physics/contact/soft_samples.hpp"

#include <algorithm>
#include <array>
#include <numeric>

#include "framework/core/check.hpp"

namespace tactor {

namespace {
constexpr std::size_t leaf_samples = 4;
}

SoftSampleTree::SoftSampleTree(const std::vector<SurfaceSample>& samples) {
  for (const SurfaceSample& s : samples) points_.push_back(s.p);
  order_.resize(points_.size());
  std::iota(order_.begin(), order_.end(), 0);
  if (!points_.empty()) build(0, points_.size());
}

void SoftSampleTree::build(std::size_t begin, std::size_t end) {
  const auto point = [&](std::size_t i) -> const Vec3& { return points_[static_cast<std::size_t>(order_[i])]; };
  Bounds box;
  for (std::size_t i = begin; i < end; ++i) box.add(point(i));
  const std::size_t index = balls_.size();
  balls_.push_back({.middle = box.middle()});
  for (std::size_t i = begin; i < end; ++i) {
    balls_[index].radius = std::max(balls_[index].radius, norm(point(i) - box.middle()));
  }
  if (end - begin <= leaf_samples) {
    balls_[index].first = static_cast<std::int32_t>(begin);
    balls_[index].count = static_cast<std::int32_t>(end - begin);
    return;
  }
  const int axis = box.longest_axis();
  const std::size_t half = begin + (end - begin) / 2;
  const auto at = [&](std::size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(begin), at(half), at(end), [&](std::int32_t a, std::int32_t b) {
    const double pa = points_[static_cast<std::size_t>(a)][axis], pb = points_[static_cast<std::size_t>(b)][axis];
    return pa != pb ? pa < pb : a < b;
  });
  build(begin, half);
  balls_[index].right = static_cast<std::int32_t>(balls_.size());
  build(half, end);
}

void SoftSampleTree::find(const MovingSurface& surface, const Pose& X_WB, double margin, int* left,
                          SoftSampleMemory& memory, std::vector<NearSoftSample>& found) const {
  using Look = SoftSampleMemory::Look;
  constexpr double rounding = 1e-9;  // of distances
  TACTOR_DEMAND(memory.balls.size() == balls_.size() && memory.samples.size() == points_.size());
  found.clear();
  if (balls_.empty()) return;
  const auto is_known = [&](const Look& look) { return look.times_placed == surface.times_placed(); };
  // m, by how much the distance from p_W may be other than it was.
  const auto way_since = [&](const Look& look, const Vec3& p_W) {
    return (norm(p_W - look.p_W) + surface.way() - look.way) * (1 + rounding);
  };
  const auto look_from = [&](const Vec3& p_W, std::int32_t hint, Look& look) {
    const SurfacePoint at = surface.nearest(p_W, is_known(look) ? look.face : hint, left);
    look = {p_W, at.distance, surface.way(), at.face, surface.times_placed()};
    return at;
  };
  struct Open {
    std::int32_t ball, hint;
  };
  std::array<Open, 64> open;
  std::size_t count = 0;
  open[count++] = {0, -1};
  while (count > 0) {
    auto [k, hint] = open[--count];
    if (left != nullptr && --*left < 0) return;
    const Ball& ball = balls_[static_cast<std::size_t>(k)];
    Look& look = memory.balls[static_cast<std::size_t>(k)];
    const Vec3 middle_W = transform(X_WB, ball.middle);
    const auto is_clear = [&](double way) {
      return look.face < 0 || look.distance * (1 - rounding) - way - ball.radius >= margin;
    };
    const double way = is_known(look) ? way_since(look, middle_W) : 0;
    if (is_known(look) && is_clear(way)) continue;
    // What was near and has hardly moved is taken to be near still.
    const bool near_still = is_known(look) && !is_clear(0) && way < 0.5 * ball.radius;
    if (!near_still) {
      look_from(middle_W, hint, look);
      if (left != nullptr && *left < 0) return;
      if (is_clear(0)) continue;
    }
    if (ball.count == 0) {
      open[count++] = {ball.right, look.face};
      open[count++] = {k + 1, look.face};
      continue;
    }
    for (std::int32_t j = ball.first; j < ball.first + ball.count; ++j) {
      const std::int32_t sample = order_[static_cast<std::size_t>(j)];
      const Vec3 p_W = transform(X_WB, points_[static_cast<std::size_t>(sample)]);
      Look& last = memory.samples[static_cast<std::size_t>(sample)];
      if (is_known(last) && last.distance * (1 - rounding) - way_since(last, p_W) >= margin) continue;
      const SurfacePoint at = look_from(p_W, look.face, last);
      if (left != nullptr && *left < 0) return;
      if (at.judged && at.distance < margin) found.push_back({sample, at});
    }
  }
}

}  // namespace tactor
