#include "bench/stability/hand.hpp"

#include <algorithm>

namespace tactor::bench {

HandPath& HandPath::go(double seconds, const Vec3& p, const Vec3& turn) {
  points_.push_back({points_.back().t + seconds, p, turn, false});
  return *this;
}

HandPath& HandPath::strike(double speed, const Vec3& p) {
  const Point last = points_.back();
  points_.push_back({last.t + 2 * norm(p - last.p) / speed, p, last.turn, true});
  return *this;
}

Pose HandPath::pose(double t) const {
  const auto next = std::find_if(points_.begin(), points_.end(), [t](const Point& p) { return p.t >= t; });
  if (next == points_.end()) return {points_.back().p, from_rotation_vector(points_.back().turn)};
  if (next == points_.begin()) return {next->p, from_rotation_vector(next->turn)};
  const Point& last = *(next - 1);
  const double x = (t - last.t) / (next->t - last.t);
  const double s = next->strike ? x * x : x * x * x * (10 + x * (6 * x - 15));
  return {last.p + s * (next->p - last.p), from_rotation_vector(last.turn + s * (next->turn - last.turn))};
}

DeviceState HandPath::at(Time t, Time before) const {
  DeviceState state;
  state.X_WD = pose(t.seconds());
  const double span = (t - before).seconds();
  if (span > 0) {
    const Pose then = pose(before.seconds());
    state.V_WD.v = (state.X_WD.p - then.p) / span;
    if (!(state.X_WD.R == then.R)) state.V_WD.w = to_rotation_vector(state.X_WD.R * inverse(then.R)) / span;
  }
  return state;
}

}  // namespace tactor::bench
