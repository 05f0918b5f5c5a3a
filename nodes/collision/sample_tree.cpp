#include "nodes/collision/sample_tree.hpp"

#include <algorithm>
#include <numeric>

namespace tactor {

SampleTree::SampleTree(const std::vector<SurfaceSample>& samples) {
  std::vector<int> order(samples.size());
  std::iota(order.begin(), order.end(), 0);
  spheres_.reserve(2 * samples.size());
  if (!samples.empty()) build(samples, order, 0, order.size());
}

void SampleTree::build(const std::vector<SurfaceSample>& samples, std::vector<int>& order, std::size_t begin,
                       std::size_t end) {
  const auto at = [&](int i) -> const Vec3& { return samples[static_cast<std::size_t>(i)].p; };
  Vec3 low = at(order[begin]), high = low;
  for (std::size_t i = begin; i < end; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], at(order[i])[axis]);
      high[axis] = std::max(high[axis], at(order[i])[axis]);
    }
  }
  const std::size_t index = spheres_.size();
  Sphere sphere;
  sphere.center = 0.5 * (low + high);
  for (std::size_t i = begin; i < end; ++i) {
    sphere.radius = std::max(sphere.radius, norm(at(order[i]) - sphere.center));
  }
  if (end - begin == 1) {
    sphere.sample = order[begin];
    sphere.center = at(order[begin]);
    sphere.radius = 0;
  }
  spheres_.push_back(sphere);
  if (end - begin > 1) {
    const Vec3 size = high - low;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const std::size_t middle = begin + (end - begin) / 2;
    const auto place = [&](std::size_t i) { return order.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(place(begin), place(middle), place(end),
                     [&](int a, int b) { return at(a)[axis] != at(b)[axis] ? at(a)[axis] < at(b)[axis] : a < b; });
    build(samples, order, begin, middle);
    build(samples, order, middle, end);
  }
  spheres_[index].after = static_cast<int>(spheres_.size());
}

void SampleTree::find(const ExactDistance& other, const Pose& X_OB, double margin, std::vector<NearSample>& found) {
  // Rounding must not make a bound cut off what it just touches.
  constexpr double slack = 1e-12;
  found.clear();
  int hint = -1;
  for (std::size_t i = 0; i < spheres_.size();) {
    Sphere& s = spheres_[i];
    const Vec3 x = transform(X_OB, s.center);
    const double reach = s.radius + margin + slack;
    if (s.face >= 0) {
      const double moved = norm(x - s.asked_at);
      if (s.distance - moved > reach) {
        i = static_cast<std::size_t>(s.after);
        continue;
      }
      if (s.sample < 0 && s.distance + moved <= s.radius + margin) {
        ++i;
        continue;
      }
      hint = s.face;
    }
    const Nearest nearest = other.query(x, hint);
    s.asked_at = x;
    s.distance = nearest.distance;
    s.face = nearest.face;
    hint = nearest.face;
    if (nearest.distance > reach) {
      i = static_cast<std::size_t>(s.after);
      continue;
    }
    if (s.sample >= 0 && nearest.distance < margin) found.push_back({s.sample, nearest});
    ++i;
  }
}

}  // namespace tactor
