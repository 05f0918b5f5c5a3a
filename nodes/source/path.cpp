#include "nodes/source/path.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

/// Second derivatives of the natural cubic spline through `value` at `points` (Thomas algorithm; the matrix is
/// diagonally dominant, so no pivoting is needed).
template <class Value>
std::vector<Vec3> spline_curvature(const std::vector<WayPoint>& points, Value value) {
  const std::size_t n = points.size();
  std::vector<Vec3> curvature(n);
  if (n < 3) return curvature;
  std::vector<double> upper(n, 0.0);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double before = points[i].t - points[i - 1].t;
    const double after = points[i + 1].t - points[i].t;
    const Vec3 bend =
        6.0 * ((value(points[i + 1]) - value(points[i])) / after - (value(points[i]) - value(points[i - 1])) / before);
    const double pivot = 2.0 * (before + after) - before * upper[i - 1];
    upper[i] = after / pivot;
    curvature[i] = (bend - before * curvature[i - 1]) / pivot;
  }
  for (std::size_t i = n - 2; i > 0; --i) curvature[i] -= upper[i] * curvature[i + 1];
  return curvature;
}

struct SplineValue {
  Vec3 value;
  Vec3 rate;
};

SplineValue spline_at(const Vec3& y0, const Vec3& y1, const Vec3& m0, const Vec3& m1, double h, double tau) {
  const double a = 1.0 - tau;
  const double b = tau;
  return {a * y0 + b * y1 + (h * h / 6.0) * ((a * a * a - a) * m0 + (b * b * b - b) * m1),
          (y1 - y0) / h + (h / 6.0) * ((3.0 * b * b - 1.0) * m1 - (3.0 * a * a - 1.0) * m0)};
}

/// The angular velocity of exp(r(t)): w = J_l(r) dr/dt, with J_l the left Jacobian of SO(3)
/// (Barfoot, State Estimation for Robotics, eq. 7.77).
Vec3 angular_velocity_of(const Vec3& r, const Vec3& rate) {
  const double angle = norm(r);
  const double square = angle * angle;
  // Series near zero, where the quotients lose their digits.
  const double first = angle < 1e-3 ? 0.5 - square / 24.0 : (1.0 - std::cos(angle)) / square;
  const double second = angle < 1e-3 ? 1.0 / 6.0 - square / 120.0 : (angle - std::sin(angle)) / (square * angle);
  const Vec3 turned = cross(r, rate);
  return rate + first * turned + second * cross(r, turned);
}

/// `r` with the whole turns that bring it nearest to `previous`.
Vec3 unwrapped(const Vec3& r, const Vec3& previous) {
  const double angle = norm(r);
  if (angle == 0) {
    // No axis of its own: whole turns are taken about the previous one.
    const double turns = std::round(norm(previous) / (2 * std::numbers::pi));
    return turns == 0 ? r : (2 * std::numbers::pi * turns / norm(previous)) * previous;
  }
  const Vec3 axis = r / angle;
  return r + (2 * std::numbers::pi * std::round((dot(previous, axis) - angle) / (2 * std::numbers::pi))) * axis;
}

}  // namespace

Path::Path(std::vector<WayPoint> points, PathKind kind, const std::string& where)
    : points_(std::move(points)), kind_(kind) {
  if (points_.empty()) throw InputError(where + ": a path needs at least one way-point, found none");
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (!std::isfinite(points_[i].t) || !is_finite(points_[i].p_WH) || !is_finite(points_[i].r_WH)) {
      throw InputError(where + ": way-point " + std::to_string(i + 1) + " holds a number that is not finite");
    }
    if (i > 0 && points_[i].t <= points_[i - 1].t) {
      throw InputError(where + ": the times of way-points must increase; way-point " + std::to_string(i + 1) +
                       " is at " + std::to_string(points_[i].t) + " s, the one before it at " +
                       std::to_string(points_[i - 1].t) + " s");
    }
  }
  if (kind_ == PathKind::cubic) {
    for (std::size_t i = 1; i < points_.size(); ++i) points_[i].r_WH = unwrapped(points_[i].r_WH, points_[i - 1].r_WH);
    p_curvature_ = spline_curvature(points_, [](const WayPoint& w) { return w.p_WH; });
    r_curvature_ = spline_curvature(points_, [](const WayPoint& w) { return w.r_WH; });
  }
}

Target Path::at(double t, bool rotate) const {
  const auto resting = [rotate](const WayPoint& point) {
    Target target;
    target.X_WH.p = point.p_WH;
    if (rotate) target.X_WH.R = from_rotation_vector(point.r_WH);
    return target;
  };
  if (t < points_.front().t) return resting(points_.front());
  if (t >= points_.back().t) return resting(points_.back());
  const auto next = std::upper_bound(points_.begin(), points_.end(), t,
                                     [](double time, const WayPoint& point) { return time < point.t; });
  const auto leg = static_cast<std::size_t>(next - points_.begin()) - 1;
  return kind_ == PathKind::cubic ? along_spline(leg, t, rotate) : along_leg(leg, t, rotate);
}

Target Path::along_leg(std::size_t leg, double t, bool rotate) const {
  const WayPoint& from = points_[leg];
  const WayPoint& to = points_[leg + 1];
  const double length = to.t - from.t;
  const double tau = (t - from.t) / length;
  double s = tau;
  double rate = 1.0 / length;
  if (kind_ == PathKind::minimum_jerk) {
    s = tau * tau * tau * (10.0 + tau * (-15.0 + 6.0 * tau));
    rate *= 30.0 * tau * tau * (1.0 - tau) * (1.0 - tau);
  }
  Target target;
  target.X_WH.p = from.p_WH + s * (to.p_WH - from.p_WH);
  target.V_WH.v = rate * (to.p_WH - from.p_WH);
  if (rotate) {
    const Quat R_from = from_rotation_vector(from.r_WH);
    const Vec3 arc_W = to_rotation_vector(from_rotation_vector(to.r_WH) * inverse(R_from));
    target.X_WH.R = from_rotation_vector(s * arc_W) * R_from;
    target.V_WH.w = rate * arc_W;
  }
  return target;
}

Target Path::along_spline(std::size_t leg, double t, bool rotate) const {
  const WayPoint& from = points_[leg];
  const WayPoint& to = points_[leg + 1];
  const double length = to.t - from.t;
  const double tau = (t - from.t) / length;
  const SplineValue p = spline_at(from.p_WH, to.p_WH, p_curvature_[leg], p_curvature_[leg + 1], length, tau);
  Target target;
  target.X_WH.p = p.value;
  target.V_WH.v = p.rate;
  if (rotate) {
    const SplineValue r = spline_at(from.r_WH, to.r_WH, r_curvature_[leg], r_curvature_[leg + 1], length, tau);
    target.X_WH.R = from_rotation_vector(r.value);
    target.V_WH.w = angular_velocity_of(r.value, r.rate);
  }
  return target;
}

}  // namespace tactor
