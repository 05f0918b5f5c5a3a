// The hand: where it is at any time, and what a device shows of it.
#pragma once

#include <vector>

#include "framework/core/messages.hpp"
#include "framework/core/time.hpp"

namespace tactor::bench {

/// Goes from point to point by minimum jerk or by a strike, and waits where two points are the same.
class HandPath {
 public:
  explicit HandPath(const Vec3& start) : points_{{0, start, {}, false}} {}

  /// Goes on to p (m, in W), turned by `turn` (rad, rotation vector), within `seconds`.
  HandPath& go(double seconds, const Vec3& p, const Vec3& turn = {});
  /// Goes on to p evenly faster until `speed` (m/s), and stops there dead.
  HandPath& strike(double speed, const Vec3& p);
  /// Stays for `seconds`.
  HandPath& stay(double seconds) { return go(seconds, points_.back().p, points_.back().turn); }

  [[nodiscard]] double end() const { return points_.back().t; }
  [[nodiscard]] const Vec3& p() const { return points_.back().p; }
  /// The pose at t, and the mean velocity since `before`, so that force times way is what the hand gives.
  [[nodiscard]] DeviceState at(Time t, Time before) const;

 private:
  struct Point {
    double t;
    Vec3 p, turn;
    bool strike;  // how it is reached
  };
  [[nodiscard]] Pose pose(double t) const;
  std::vector<Point> points_;
};

}  // namespace tactor::bench
