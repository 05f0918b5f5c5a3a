#include "devices/mouse/cursor_filter.hpp"

#include <cmath>

namespace tactor {

namespace {

/// The deviation x - goal and its rate after `t` seconds: e(t) = (e + (v + w e) t) exp(-w t).
void relax(Vec3& deviation, Vec3& rate, double w, double t) {
  const double decay = std::exp(-w * t);
  const Vec3 drive = rate + w * deviation;
  const Vec3 next = decay * (deviation + t * drive);
  rate = decay * drive - w * next;
  deviation = next;
}

}  // namespace

void CursorFilter::advance(double seconds, const Pose& cursor, bool rotates) {
  const double w = 1.0 / limits_.time_constant;
  goal_.p += limited(cursor.p - goal_.p, limits_.speed * seconds);
  Vec3 deviation = state_.X.p - goal_.p;
  relax(deviation, state_.V.v, w, seconds);
  state_.X.p = goal_.p + deviation;
  if (!rotates) return;
  const Vec3 turn = to_rotation_vector(cursor.R * inverse(goal_.R));
  goal_.R = normalized(from_rotation_vector(limited(turn, limits_.angular_speed * seconds)) * goal_.R);
  Vec3 twist = to_rotation_vector(state_.X.R * inverse(goal_.R));
  relax(twist, state_.V.w, w, seconds);
  state_.X.R = normalized(from_rotation_vector(twist) * goal_.R);
}

}  // namespace tactor
