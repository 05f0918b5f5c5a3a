#include "nodes/physics/contact/soft_samples.hpp"

#include <algorithm>
#include <array>
#include <numeric>

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
                          std::vector<NearSoftSample>& found) const {
  constexpr double rounding = 1e-9;  // of distances
  found.clear();
  if (balls_.empty()) return;
  struct Open {
    std::int32_t ball, hint;
  };
  std::array<Open, 64> open;
  std::size_t count = 0;
  open[count++] = {0, -1};
  while (count > 0) {
    auto [k, hint] = open[--count];
    const Ball& ball = balls_[static_cast<std::size_t>(k)];
    const SurfacePoint middle = surface.nearest(transform(X_WB, ball.middle), hint, left);
    if (left != nullptr && *left < 0) return;
    if (middle.face < 0 || middle.distance * (1 - rounding) - ball.radius >= margin) continue;
    if (ball.count == 0) {
      open[count++] = {ball.right, middle.face};
      open[count++] = {k + 1, middle.face};
      continue;
    }
    for (std::int32_t j = ball.first; j < ball.first + ball.count; ++j) {
      const std::int32_t sample = order_[static_cast<std::size_t>(j)];
      const SurfacePoint at =
          surface.nearest(transform(X_WB, points_[static_cast<std::size_t>(sample)]), middle.face, left);
      if (left != nullptr && *left < 0) return;
      if (at.judged && at.distance < margin) found.push_back({sample, at});
    }
  }
}

}  // namespace tactor
