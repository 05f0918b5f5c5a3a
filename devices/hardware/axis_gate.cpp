#include "devices/hardware/axis_gate.hpp"

#include <algorithm>
#include <cmath>

namespace tactor {

namespace {

constexpr Duration speed_window{10'000'000};
constexpr Duration longest_step{20'000'000};  // that an effort may make up for: a line that stood still gains nothing
constexpr double warm = 0.8;                  // share of the heat from which on the effort is lowered

}  // namespace

const char* words_of(GateHold hold) {
  switch (hold) {
    case GateHold::outside:
      return "its handle is outside the workspace and the force went on";
    case GateHold::speed:
      return "its handle is faster than its axes can be moved";
    case GateHold::none:
      break;
  }
  return "nothing";
}

void WindingHeat::add(double effort, double seconds) noexcept {
  if (!(continuous_ > 0) || !(time_ > 0) || !(seconds > 0)) return;
  const double u = effort / continuous_;
  // The exact answer of the model to an effort that stays the same.
  share_ += (u * u - share_) * -std::expm1(-seconds / time_);
}

double WindingHeat::most(double effort_max) const noexcept {
  if (!(continuous_ > 0) || !(time_ > 0) || share_ <= warm || continuous_ >= effort_max) return effort_max;
  const double left = std::max(0.0, (1 - share_) / (1 - warm));
  return continuous_ + (effort_max - continuous_) * left;
}

AxisGate::AxisGate(const AxisGateLimits& limits) : limits_(limits) {
  for (std::size_t a = 0; a < max_axes; ++a) heat_[a] = {limits.continuous[a], limits.thermal_time[a]};
}

void AxisGate::reopen() noexcept {
  looks_ = is_outside_ = is_fast_ = false;
}

void AxisGate::see(Instant sampled, const AxisValues& q, const AxisLimits& axes) noexcept {
  is_outside_ = !axes.contains(q);
  if (!limits_.speed) return;
  if (!looks_) {
    looks_ = true;
    looked_ = sampled;
    looked_q_ = q;
    return;
  }
  const Duration since = sampled - looked_;
  if (since < speed_window) return;
  is_fast_ = false;
  for (std::size_t a = 0; a < static_cast<std::size_t>(axes.axes); ++a) {
    const double reach = axes.speed_max[a] * since.seconds() + axes.jump_tolerance[a];
    is_fast_ = is_fast_ || std::abs(q[a] - looked_q_[a]) > reach;
  }
  looked_ = sampled;
  looked_q_ = q;
}

void AxisGate::watch(Instant now, bool any_effort) noexcept {
  if (!is_outside_ || !any_effort) outside_since_ = now;
  if (hold_ != GateHold::none) return;
  if (is_fast_) {
    hold_ = GateHold::speed;
  } else if (now - outside_since_ > limits_.patience) {
    hold_ = GateHold::outside;
  }
  held_share_ = 1;
}

AxisValues AxisGate::give(Instant now, const AxisValues& wanted, const AxisLimits& axes) noexcept {
  const bool any_effort = wanted != AxisValues{};
  const double seconds = any_given_ ? std::min(now - given_at_, longest_step).seconds() : 0;
  watch(now, any_effort);
  AxisValues given = wanted;
  if (hold_ != GateHold::none) {
    if (!any_effort && !is_fast_ && !is_outside_) {
      hold_ = GateHold::none;
    } else {
      held_share_ = std::max(0.0, held_share_ - seconds / limits_.let_go.seconds());
      for (double& one : given) one *= held_share_;
    }
  }
  for (std::size_t a = 0; a < static_cast<std::size_t>(axes.axes); ++a) {
    const double most = heat_[a].most(axes.effort_max[a]);
    double size = std::min(std::abs(given[a]), most);
    // An effort that turns round begins at zero.
    const double before = given[a] * given_[a] > 0 ? std::abs(given_[a]) : 0;
    if (std::isfinite(limits_.slew[a])) size = std::min(size, before + limits_.slew[a] * seconds);
    given[a] = std::copysign(size, given[a]);
    if (size == 0) given[a] = 0;
  }
  return given;
}

void AxisGate::gave(Instant now, const AxisValues& efforts) noexcept {
  if (any_given_) {
    for (std::size_t a = 0; a < max_axes; ++a) heat_[a].add(given_[a], (now - given_at_).seconds());
  }
  any_given_ = true;
  given_at_ = now;
  given_ = efforts;
}

}  // namespace tactor
