#include "bench/collision/trilinear_distance.hpp"

#include <algorithm>
#include <cmath>

#include "nodes/physics/cgal/exact_distance.hpp"
#include "nodes/physics/mesh/bounds.hpp"

namespace tactor::bench {

namespace {

std::size_t index(int i) {
  return static_cast<std::size_t>(i);
}

}  // namespace

TrilinearDistance::TrilinearDistance(const TriangleMesh& mesh, int cells) {
  const Bounds bounds = bounds_of(mesh);
  cell_ = bounds.longest() / cells;
  // Two cells of room around it.
  origin_ = bounds.low - Vec3{2 * cell_, 2 * cell_, 2 * cell_};
  for (int k = 0; k < 3; ++k) corners_[index(k)] = static_cast<int>(std::ceil(bounds.size()[k] / cell_)) + 5;
  values_.resize(index(corners_[0]) * index(corners_[1]) * index(corners_[2]));

  const ExactDistance exact(mesh);
  constexpr int block = 8;
  constexpr double band = 0.004, half = 0.5 * (block - 1);
  int hint = -1;
  for (int k = 0; k < corners_[2]; k += block) {
    for (int j = 0; j < corners_[1]; j += block) {
      for (int i = 0; i < corners_[0]; i += block) {
        const Nearest middle = exact.nearest(origin_ + cell_ * Vec3{i + half, j + half, k + half}, hint);
        hint = middle.face;
        const double spare = std::abs(middle.distance) - std::sqrt(3.0) * half * cell_;
        for (int c = k; c < std::min(k + block, corners_[2]); ++c) {
          for (int b = j; b < std::min(j + block, corners_[1]); ++b) {
            for (int a = i; a < std::min(i + block, corners_[0]); ++a) {
              double d = std::copysign(spare, middle.distance);
              if (spare < band) {
                const Vec3 corner = origin_ + cell_ * Vec3{double(a), double(b), double(c)};
                const Nearest nearest = exact.nearest(corner, hint);
                d = nearest.distance, hint = nearest.face;
              }
              values_[place(index(a), index(b), index(c))] = static_cast<float>(d);
            }
          }
        }
      }
    }
  }
}

std::size_t TrilinearDistance::place(std::size_t i, std::size_t j, std::size_t k) const {
  return i + index(corners_[0]) * (j + index(corners_[1]) * k);
}

Nearest TrilinearDistance::nearest(const Vec3& x, int /*hint*/) const {
  std::array<std::size_t, 3> i{};
  Vec3 u;
  double outside = 0;
  for (int k = 0; k < 3; ++k) {
    const double scaled = (x[k] - origin_[k]) / cell_;
    const double inside = std::clamp(scaled, 0.0, corners_[index(k)] - 1.001);
    outside = std::max(outside, std::abs(scaled - inside));
    i[index(k)] = static_cast<std::size_t>(inside);
    u[k] = inside - std::floor(inside);
  }
  Nearest result;
  if (outside > 0) {
    result.distance = cell_ * (outside + 1);
    return result;
  }
  const float* v = &values_[place(i[0], i[1], i[2])];
  const std::size_t dy = index(corners_[0]), dz = dy * index(corners_[1]);
  const auto c = [&](std::size_t offset) { return static_cast<double>(v[offset]); };
  const auto mix = [](double a, double b, double t) { return a + t * (b - a); };
  const double x00 = mix(c(0), c(1), u.x), x10 = mix(c(dy), c(dy + 1), u.x);
  const double x01 = mix(c(dz), c(dz + 1), u.x), x11 = mix(c(dy + dz), c(dy + dz + 1), u.x);
  const double y0 = mix(x00, x10, u.y), y1 = mix(x01, x11, u.y);
  const double gx =
      mix(mix(c(1) - c(0), c(dy + 1) - c(dy), u.y), mix(c(dz + 1) - c(dz), c(dy + dz + 1) - c(dy + dz), u.y), u.z);
  const Vec3 g{gx, mix(x10 - x00, x11 - x01, u.z), y1 - y0};
  const double length = norm(g);
  result.distance = mix(y0, y1, u.z);
  if (length > 0) result.gradient = g / length;
  result.p = x - result.distance * result.gradient;
  return result;
}

void TrilinearDistance::lower_bounds(const Points8& x, unsigned wanted, std::array<float, 8>& bound) const {
  for (std::size_t k = 0; k < 8; ++k) {
    if ((wanted >> k & 1) == 0) continue;
    // The interpolation is off the distance by a cell at most, there and where it is asked for later.
    bound[k] = static_cast<float>(nearest({x.x[k], x.y[k], x.z[k]}).distance - 2 * cell_);
  }
}

Eigen::Matrix3d TrilinearDistance::hessian(const Nearest& /*nearest*/, const Vec3& /*x*/) const {
  return Eigen::Matrix3d::Zero();
}

}  // namespace tactor::bench
