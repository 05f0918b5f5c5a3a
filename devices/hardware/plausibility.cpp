#include "devices/hardware/plausibility.hpp"

#include <cmath>

namespace tactor {

Plausibility::Verdict Plausibility::judge(const AxisValues& q, Instant sampled, const AxisValues& effort) noexcept {
  const bool jump = jumped(q, sampled);
  const bool still = stuck(q, sampled, effort);
  any_ = true;
  last_ = q;
  if (jump) return Verdict::jumped;
  believed_ = q;
  believed_at_ = sampled;
  return still ? Verdict::stuck : Verdict::good;
}

bool Plausibility::jumped(const AxisValues& q, Instant sampled) noexcept {
  if (!any_) {
    believed_ = q;
    believed_at_ = sampled;
  }
  const Duration time = distrusted_ ? reach_time_ : sampled - believed_at_;
  for (int i = 0; i < limits_.axes; ++i) {
    const auto a = static_cast<std::size_t>(i);
    const double reach = limits_.speed_max[a] * std::max(0.0, time.seconds()) + limits_.jump_tolerance[a];
    // Written so that not-a-number is a jump too.
    if (std::abs(q[a] - believed_[a]) <= reach) continue;
    if (!distrusted_) {
      ++jumps_;
      finding_ = {i, believed_[a], q[a], time};
      reach_time_ = time;
    }
    distrusted_ = true;
    return true;
  }
  distrusted_ = false;
  return false;
}

bool Plausibility::stuck(const AxisValues& q, Instant sampled, const AxisValues& effort) noexcept {
  if (limits_.stuck_after.ns <= 0) return false;
  bool any_stuck = false;
  for (int i = 0; i < limits_.axes; ++i) {
    const auto a = static_cast<std::size_t>(i);
    const bool driven = std::abs(effort[a]) >= limits_.stuck_share * limits_.effort_max[a] && effort[a] != 0;
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
