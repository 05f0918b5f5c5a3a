#include "nodes/forcefield/half_spaces.hpp"

#include <cmath>

namespace tactor {

namespace {

/// m, far below what an encoder shows and far above rounding in scenes of metres.
constexpr double beyond = 1e-12;
/// rad: between planes at a smaller angle there is nothing but rounding. At larger ones each counts, or a proxy would
/// rest where two faces of a fine mesh meet.
constexpr double same_direction = 1e-13;
/// Determinants of normals' products below it leave no digits.
constexpr double least_determinant = 1e-18;

}  // namespace

bool HalfSpaces::add(const HalfSpace& plane) {
  if (count_ == capacity) return false;
  for (std::size_t i = 0; i < count_; ++i) {
    if (norm(planes_[i].n - plane.n) < same_direction) return false;
  }
  planes_[count_++] = plane;
  return true;
}

bool HalfSpaces::allowed(const Vec3& x) const {
  for (std::size_t i = 0; i < count_; ++i) {
    if (dot(planes_[i].n, x) < planes_[i].b - beyond) return false;
  }
  return true;
}

HalfSpaces::NearestAllowed HalfSpaces::nearest(const Vec3& goal) const {
  NearestAllowed result;
  if (allowed(goal)) {
    result.x = goal;
    result.found = true;
    return result;
  }
  std::array<double, capacity> short_of{};  // m, how far the goal is beyond each plane
  for (std::size_t i = 0; i < count_; ++i) short_of[i] = planes_[i].b - dot(planes_[i].n, goal);
  const auto take = [&](const Vec3& x) {
    if (!allowed(x)) return false;
    result.x = x;
    return result.found = true;
  };
  for (std::size_t i = 0; i < count_; ++i) {
    if (short_of[i] < 0 || !take(goal + short_of[i] * planes_[i].n)) continue;
    result.push[i] = short_of[i];
    return result;
  }
  for (std::size_t i = 0; i < count_; ++i) {
    for (std::size_t j = i + 1; j < count_; ++j) {
      // The square of the sine; 1 - c^2 has no digits where it is small.
      const Vec3 axis = cross(planes_[i].n, planes_[j].n);
      const double c = dot(planes_[i].n, planes_[j].n), determinant = dot(axis, axis);
      if (determinant < least_determinant) continue;
      const double a = (short_of[i] - c * short_of[j]) / determinant, b = (short_of[j] - c * short_of[i]) / determinant;
      if (a < 0 || b < 0 || !take(goal + a * planes_[i].n + b * planes_[j].n)) continue;
      result.push[i] = a, result.push[j] = b;
      return result;
    }
  }
  for (std::size_t i = 0; i < count_; ++i) {
    for (std::size_t j = i + 1; j < count_; ++j) {
      for (std::size_t k = j + 1; k < count_; ++k) {
        const Vec3 &n = planes_[i].n, &m = planes_[j].n, &o = planes_[k].n;
        // x is where three planes meet; the pushes are those of x - goal in the basis of their normals.
        const Vec3 mo = cross(m, o), on = cross(o, n), nm = cross(n, m);
        const double volume = dot(n, mo);
        if (volume * volume < least_determinant) continue;
        const Vec3 way = (short_of[i] * mo + short_of[j] * on + short_of[k] * nm) / volume;
        const double a = dot(way, mo) / volume, b = dot(way, on) / volume, c = dot(way, nm) / volume;
        if (a < 0 || b < 0 || c < 0 || !take(goal + way)) continue;
        result.push[i] = a, result.push[j] = b, result.push[k] = c;
        return result;
      }
    }
  }
  return result;
}

}  // namespace tactor
