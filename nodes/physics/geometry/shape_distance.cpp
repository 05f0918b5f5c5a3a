#include "nodes/physics/geometry/shape_distance.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "framework/core/check.hpp"
#include "nodes/physics/geometry/outward.hpp"

namespace tactor {

namespace {

using Eigen::Matrix3d;

// Nearer than rounding, a difference has no direction.
constexpr double no_direction = 1e-12;

Matrix3d across(const Vec3& n) {
  const Eigen::Vector3d u(n.x, n.y, n.z);
  return Matrix3d::Identity() - u * u.transpose();
}

/// Fills in lower_bounds from the exact distance of derived class D.
template <class D>
class Shaped : public SignedDistance {
 public:
  void lower_bounds(const Points8& x, unsigned wanted, std::array<float, 8>& bound) const final {
    for (std::size_t k = 0; k < 8; ++k) {
      if ((wanted >> k & 1) == 0) continue;
      const double d = static_cast<const D&>(*this).distance({x.x[k], x.y[k], x.z[k]});
      bound[k] = rounded_down(d);
    }
  }
};

class SphereDistance final : public Shaped<SphereDistance> {
 public:
  explicit SphereDistance(const SphereShape& shape) : radius_(shape.radius) {}
  [[nodiscard]] double distance(const Vec3& x) const { return norm(x) - radius_; }
  [[nodiscard]] Nearest nearest(const Vec3& x, int /*hint*/) const override {
    const double length = norm(x);
    const Vec3 n = length < no_direction ? Vec3{0, 0, 1} : x / length;
    return {length - radius_, radius_ * n, n, 0};
  }
  [[nodiscard]] Matrix3d hessian(const Nearest& nearest, const Vec3& x) const override {
    const double length = norm(x);
    if (length < no_direction) return Matrix3d::Zero();
    return across(nearest.gradient) / length;
  }

 private:
  double radius_;  // m
};

class CapsuleDistance final : public Shaped<CapsuleDistance> {
 public:
  explicit CapsuleDistance(const CapsuleShape& shape) : radius_(shape.radius), half_(0.5 * shape.length) {}
  [[nodiscard]] double distance(const Vec3& x) const { return norm(x - on_axis(x)) - radius_; }
  [[nodiscard]] Nearest nearest(const Vec3& x, int /*hint*/) const override {
    const Vec3 a = on_axis(x), away = x - a;
    const double length = norm(away);
    const Vec3 n = length < no_direction ? Vec3{1, 0, 0} : away / length;
    return {length - radius_, a + radius_ * n, n, x.z > half_ ? 1 : x.z < -half_ ? 2 : 0};
  }
  [[nodiscard]] Matrix3d hessian(const Nearest& nearest, const Vec3& x) const override {
    const double length = norm(x - on_axis(x));
    if (length < no_direction) return Matrix3d::Zero();
    Matrix3d flat = across(nearest.gradient);
    if (nearest.face == 0) flat(2, 2) = 0;
    return flat / length;
  }

 private:
  [[nodiscard]] Vec3 on_axis(const Vec3& x) const { return {0, 0, std::clamp(x.z, -half_, half_)}; }
  double radius_;  // m
  double half_;    // m, of the segment's length
};

class BoxDistance final : public Shaped<BoxDistance> {
 public:
  explicit BoxDistance(const BoxShape& shape) : half_(0.5 * shape.size) {}

  [[nodiscard]] double distance(const Vec3& x) const {
    const Vec3 out = beyond(x);
    const Vec3 away{std::max(out.x, 0.0), std::max(out.y, 0.0), std::max(out.z, 0.0)};
    return norm(away) + std::min(std::max({out.x, out.y, out.z}), 0.0);
  }

  [[nodiscard]] Nearest nearest(const Vec3& x, int /*hint*/) const override {
    const Vec3 out = beyond(x);
    int first = 0;
    for (int axis = 1; axis < 3; ++axis) {
      if (out[axis] > out[first]) first = axis;
    }
    Nearest n;
    n.p = x;
    if (out[first] <= -no_direction) {
      n.p[first] = side(x, first) * half_[first];
      n.gradient[first] = side(x, first);
      n.distance = out[first];
      n.face = face(x, first);
      return n;
    }
    Vec3 away;
    for (int axis = 0; axis < 3; ++axis) {
      n.p[axis] = std::clamp(x[axis], -half_[axis], half_[axis]);
      away[axis] = x[axis] - n.p[axis];
    }
    const double length = norm(away);
    const bool on_surface = length < no_direction;
    // The faces that meet at the nearest point, the first one last.
    std::array<bool, 3> meets{};
    int count = 0;
    Vec3 together;
    for (int axis = 2; axis >= 0; --axis) {
      if (!(out[axis] > (on_surface ? -no_direction : 0))) continue;
      meets[static_cast<std::size_t>(axis)] = true;
      ++count;
      together[axis] = side(x, axis);
      n.face = face(x, axis);
    }
    n.distance = on_surface ? out[first] : length;
    n.gradient = on_surface ? together / norm(together) : away / length;
    n.feature = count == 1 ? Feature::face : count == 2 ? Feature::edge : Feature::corner;
    if (count == 2) n.of_face = meets[0] ? (meets[1] ? 2 : 1) : 0;
    if (count == 3) n.of_face = static_cast<std::uint8_t>((x.x >= 0) + 2 * (x.y >= 0) + 4 * (x.z >= 0));
    return n;
  }

  [[nodiscard]] Matrix3d hessian(const Nearest& nearest, const Vec3& /*x*/) const override {
    if (nearest.feature == Feature::face || std::abs(nearest.distance) < no_direction) return Matrix3d::Zero();
    Matrix3d flat = across(nearest.gradient);
    if (nearest.feature == Feature::edge) flat(nearest.of_face, nearest.of_face) = 0;
    return flat / nearest.distance;
  }

 private:
  [[nodiscard]] Vec3 beyond(const Vec3& x) const {
    return {std::abs(x.x) - half_.x, std::abs(x.y) - half_.y, std::abs(x.z) - half_.z};
  }
  static double side(const Vec3& x, int axis) { return x[axis] >= 0 ? 1 : -1; }
  static int face(const Vec3& x, int axis) { return 2 * axis + (x[axis] >= 0 ? 1 : 0); }
  Vec3 half_;  // m
};

class PlaneDistance final : public Shaped<PlaneDistance> {
 public:
  [[nodiscard]] static double distance(const Vec3& x) { return x.z; }
  [[nodiscard]] Nearest nearest(const Vec3& x, int /*hint*/) const override {
    return {x.z, {x.x, x.y, 0}, {0, 0, 1}, 0};
  }
  [[nodiscard]] Matrix3d hessian(const Nearest& /*nearest*/, const Vec3& /*x*/) const override {
    return Matrix3d::Zero();
  }
};

}  // namespace

std::unique_ptr<SignedDistance> shape_distance(const Shape& shape) {
  if (const auto* sphere = std::get_if<SphereShape>(&shape)) return std::make_unique<SphereDistance>(*sphere);
  if (const auto* capsule = std::get_if<CapsuleShape>(&shape)) return std::make_unique<CapsuleDistance>(*capsule);
  if (const auto* box = std::get_if<BoxShape>(&shape)) return std::make_unique<BoxDistance>(*box);
  if (std::holds_alternative<PlaneShape>(shape)) return std::make_unique<PlaneDistance>();
  throw InputError("a mesh has no distance in closed form");
}

}  // namespace tactor
