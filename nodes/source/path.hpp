// A path through timed way-points as a function of time, with its analytic velocity.
#pragma once

#include <string>
#include <vector>

#include "framework/core/messages.hpp"

namespace tactor {

/// A point that a path passes at a time.
struct WayPoint {
  double t = 0;  ///< s since the start of the run
  Vec3 p_WH;     ///< m
  Vec3 r_WH;     ///< rad, rotation vector of R_WH
};

/// How a path moves between its way-points; with tau in [0, 1] over a leg from p0 to p1.
enum class PathKind {
  minimum_jerk,  ///< p0 + (p1 - p0)(10 tau^3 - 15 tau^4 + 6 tau^5): rest to rest (Flash and Hogan 1985, eq. 2)
  linear,        ///< p0 + (p1 - p0) tau: constant velocity, which jumps at way-points
  cubic,         ///< the natural cubic spline through all points: velocity and acceleration are continuous
};

/// The path. Before the first way-point it rests there, after the last one too.
///
/// Rotation: minimum_jerk and linear turn about one axis along the shorter arc, R = exp(s log(R1 R0^T)) R0; cubic is
/// the spline through the rotation vectors, each taken with the whole turns that bring it nearest to the one before.
class Path {
 public:
  /// Throws InputError, its text beginning with `where`, without points, with a number that is not finite, or where the
  /// times do not increase.
  Path(std::vector<WayPoint> points, PathKind kind, const std::string& where);

  /// Pose and velocity at `t` (s), all in W; w_WH is left at zero and R_WH at identity where `rotate` is false.
  [[nodiscard]] Target at(double t, bool rotate) const;

  [[nodiscard]] const std::vector<WayPoint>& points() const { return points_; }

 private:
  [[nodiscard]] Target along_leg(std::size_t leg, double t, bool rotate) const;
  [[nodiscard]] Target along_spline(std::size_t leg, double t, bool rotate) const;

  std::vector<WayPoint> points_;
  PathKind kind_;
  std::vector<Vec3> p_curvature_;  // second derivatives at the points, m/s^2
  std::vector<Vec3> r_curvature_;  // rad/s^2
};

}  // namespace tactor
