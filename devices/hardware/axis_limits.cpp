#include "devices/hardware/axis_limits.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

/// The largest share of efforts `first` to `last` - 1 whose norm is within the least of their limits.
double share_by_norm(const AxisLimits& limits, const AxisValues& effort, int first, int last) {
  double size = 0, most = LinkLimits::unknown;
  for (int i = first; i < last; ++i) {
    if (!limits.drives(i)) continue;
    const auto a = static_cast<std::size_t>(i);
    size = std::hypot(size, effort[a]);
    most = std::min(most, limits.effort_max[a]);
  }
  return size > most ? most / size : 1;
}

}  // namespace

int AxisLimits::handle_axes() const {
  return gripper() < 0 ? axes : axes - 1;
}

int AxisLimits::gripper() const {
  return role[static_cast<std::size_t>(axes - 1)] == AxisRole::gripper ? axes - 1 : -1;
}

bool AxisLimits::drives(int axis) const {
  const auto a = static_cast<std::size_t>(axis);
  return role[a] != AxisRole::sensed && effort_max[a] > 0;
}

void AxisLimits::tighten(const LinkLimits& theirs) {
  for (std::size_t a = 0; a < max_axes; ++a) {
    effort_max[a] = std::min(effort_max[a], theirs.effort_max[a]);
    speed_max[a] = std::min(speed_max[a], theirs.speed_max[a]);
    q_min[a] = std::max(q_min[a], theirs.q_min[a]);
    q_max[a] = std::min(q_max[a], theirs.q_max[a]);
  }
}

bool AxisLimits::contains(const AxisValues& q) const {
  const int bounded = turns() ? 3 : handle_axes();
  for (std::size_t a = 0; a < static_cast<std::size_t>(bounded); ++a) {
    if (q[a] < q_min[a] || q[a] > q_max[a]) return false;
  }
  return true;
}

bool AxisLimits::shorten(LinkCommand& command) const {
  AxisValues& effort = command.effort;
  double share = 1;
  for (int i = 0; i < max_axes; ++i) {
    double& one = effort[static_cast<std::size_t>(i)];
    if (i >= axes || !drives(i)) {
      one = command.weight[static_cast<std::size_t>(i)] = 0;
      continue;
    }
    if (!std::isfinite(one)) {
      effort = {};
      return true;
    }
    const double most = effort_max[static_cast<std::size_t>(i)];
    if (i < handle_axes() && std::abs(one) > most) share = std::min(share, most / std::abs(one));
  }
  if (pose)
    share = std::min({share, share_by_norm(*this, effort, 0, 3), share_by_norm(*this, effort, 3, handle_axes())});
  bool shortened = share < 1;
  for (int i = 0; i < axes; ++i) {
    double& one = effort[static_cast<std::size_t>(i)];
    if (i < handle_axes() && share < 1) one *= share;
    // Also because the product may round to beyond the limit.
    const double most = std::max(0.0, effort_max[static_cast<std::size_t>(i)]);
    const double within = std::clamp(one, -most, most);
    shortened = shortened || within != one;
    one = within;
  }
  return shortened;
}

void check(const AxisLimits& limits) {
  const auto refuse = [](const std::string& expected, int found) {
    throw InputError("the axes of a device: expected " + expected + ", found " + std::to_string(found));
  };
  if (limits.axes < 1 || limits.axes > max_axes) refuse("1 to " + std::to_string(max_axes), limits.axes);
  for (int i = 0; i + 1 < limits.axes; ++i) {
    if (limits.role[static_cast<std::size_t>(i)] == AxisRole::gripper) refuse("a gripper as the last one", i + 1);
  }
  for (std::size_t a = 0; a < static_cast<std::size_t>(limits.axes); ++a) {
    if (std::isfinite(limits.effort_max[a]) && std::isfinite(limits.speed_max[a])) continue;
    throw InputError("the axes of a device: expected a finite largest effort and speed of axis " +
                     std::to_string(a + 1));
  }
  const int handle = limits.handle_axes();
  if (handle < 1) refuse("at least one that moves the handle", handle);
  if (limits.pose && handle != 3 && handle != 6) refuse("3 or 6 of a pose", handle);
}

}  // namespace tactor
