// The point nearest to a goal that several planes allow.
#pragma once

#include <array>
#include <cstddef>

#include "framework/core/spatial.hpp"

namespace tactor {

/// x is allowed where dot(n, x) >= b.
struct HalfSpace {
  Vec3 n;        ///< unit
  double b = 0;  ///< m
};

/// A few of them.
class HalfSpaces {
 public:
  static constexpr std::size_t capacity = 8;

  struct NearestAllowed {
    Vec3 x;  ///< m
    /// m, how far each plane pushes: x - goal = sum push_i n_i, push_i >= 0, of three planes at most not zero.
    std::array<double, capacity> push{};
    bool found = false;
  };

  void clear() { count_ = 0; }
  [[nodiscard]] std::size_t size() const { return count_; }
  /// False where there is no room, or a plane of the same normal is there already.
  bool add(const HalfSpace& plane);
  /// Replaces plane i.
  void replace(std::size_t i, const HalfSpace& plane) { planes_[i] = plane; }

  /// The x of the least |x - goal| that all planes allow: the solution of the Karush-Kuhn-Tucker conditions, looked for
  /// among the sets of no plane, one, two and three. Not found where the planes allow nothing, or where three that are
  /// nearly parallel leave no digits.
  [[nodiscard]] NearestAllowed nearest(const Vec3& goal) const;

 private:
  [[nodiscard]] bool allowed(const Vec3& x) const;

  std::array<HalfSpace, capacity> planes_;
  std::size_t count_ = 0;
};

}  // namespace tactor
