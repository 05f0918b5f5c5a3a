#include "devices/hardware/plausibility.hpp"

#include <algorithm>
#include <cmath>

namespace tactor {

bool Plausibility::is_finite(const LinkSample& sample) const {
  for (std::size_t a = 0; a < static_cast<std::size_t>(limits_.axes); ++a) {
    if (!std::isfinite(sample.q[a])) return false;
  }
  return true;
}

Plausibility::Verdict Plausibility::judge(LinkSample& sample, Instant sampled, const AxisValues& effort) noexcept {
  Vec3 turned;  // in the base, since the sample that was believed
  if (limits_.turns()) {
    sample.R_BD = normalized(sample.R_BD);
    turned = to_rotation_vector(any_ ? sample.R_BD * inverse(believed_.R_BD) : sample.R_BD);
    const AxisValues& q = believed_.q;
    sample.q[3] = q[3] + turned.x;
    sample.q[4] = q[4] + turned.y;
    sample.q[5] = q[5] + turned.z;
  }
  if (!any_) {
    // A device that is not ready may show anything.
    if (!is_finite(sample)) return Verdict::jumped;
    believed_ = sample;
    believed_at_ = sampled;
    turned = {};
  }
  const bool jump = jumped(sample, turned, sampled);
  const bool still = stuck(sample.q, sampled, effort);
  any_ = true;
  last_ = sample.q;
  if (jump) return Verdict::jumped;
  believed_ = sample;
  believed_at_ = sampled;
  return still ? Verdict::stuck : Verdict::good;
}

bool Plausibility::jumped_by(int axis, double from, double to, Duration time) noexcept {
  const auto a = static_cast<std::size_t>(axis);
  const double reach = limits_.speed_max[a] * std::max(0.0, time.seconds()) + limits_.jump_tolerance[a];
  // Written so that not-a-number is a jump too.
  if (std::abs(to - from) <= reach) return false;
  if (!distrusted_) {
    ++jumps_;
    finding_ = {axis, from, to, time};
    reach_time_ = time;
  }
  distrusted_ = true;
  return true;
}

bool Plausibility::jumped(const LinkSample& sample, const Vec3& turned, Instant sampled) noexcept {
  const Duration time = distrusted_ ? reach_time_ : sampled - believed_at_;
  for (int i = 0; i < limits_.axes; ++i) {
    const auto a = static_cast<std::size_t>(i);
    const bool angle = limits_.turns() && i >= 3 && i < 6;
    if (jumped_by(i, angle ? 0 : believed_.q[a], angle ? norm(turned) : sample.q[a], time)) return true;
  }
  distrusted_ = false;
  return false;
}

bool Plausibility::stuck(const AxisValues& q, Instant sampled, const AxisValues& effort) noexcept {
  if (limits_.stuck_after.ns <= 0) return false;
  bool any_stuck = false;
  for (int i = 0; i < limits_.axes; ++i) {
    const auto a = static_cast<std::size_t>(i);
    const bool driven = limits_.role[a] != AxisRole::gripper &&
                        std::abs(effort[a]) >= limits_.stuck_share * limits_.effort_max[a] && effort[a] != 0;
    if (!any_ || q[a] != last_[a]) stands_[a] = false;
    if (!any_ || q[a] != last_[a] || !driven || !driven_[a]) still_since_[a] = sampled;
    driven_[a] = driven;
    if (!stands_[a] && driven && sampled - still_since_[a] >= limits_.stuck_after) {
      stands_[a] = true;
      ++times_stuck_;
      finding_ = {i, q[a], q[a], sampled - still_since_[a]};
    }
    any_stuck = any_stuck || stands_[a];
  }
  return any_stuck;
}

}  // namespace tactor
