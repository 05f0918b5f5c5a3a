// What the axes of a device are for, and what they can do.
#pragma once

#include <array>

#include "devices/hardware/line_data.hpp"
#include "framework/core/time.hpp"

namespace tactor {

/// What is known of the axes of a device, by its node and by its line.
struct AxisLimits {
  int axes = 1;
  std::array<AxisRole, max_axes> role{};  ///< a gripper comes last
  /// True for a device that shows a pose and takes a wrench: axes 0 to 2 are the place of the handle in the base, and
  /// axes 3 to 5, where it has them, its orientation, which LinkSample::R_BD shows. Its force and torque are limited by
  /// norm, to the least limit among their axes.
  bool pose = false;
  AxisValues effort_max{};                              ///< N or N m, of the device itself; 0: no motor
  AxisValues speed_max{};                               ///< m/s or rad/s, faster than which no hand moves it
  AxisValues jump_tolerance{};                          ///< m or rad, beside the speed: noise and steps of the encoder
  AxisValues q_min = every_axis(-LinkLimits::unknown);  ///< m or rad: the workspace, beyond which there is no force
  AxisValues q_max = every_axis(LinkLimits::unknown);   ///< m or rad
  Duration stuck_after{1'000'000'000};                  ///< 0: encoders may stand still for ever
  double stuck_share = 0.2;                             ///< of effort_max: what counts as driven

  /// Axes that move the handle: the first ones.
  [[nodiscard]] int handle_axes() const;
  /// The axis of the gripper; -1: there is none.
  [[nodiscard]] int gripper() const;
  /// True where axes 3 to 5 are an orientation.
  [[nodiscard]] bool turns() const { return pose && handle_axes() == 6; }
  /// True where an effort may act.
  [[nodiscard]] bool drives(int axis) const;
  /// Takes over what is tighter.
  void tighten(const LinkLimits& theirs);
  /// True where the handle is in the workspace. An orientation has no end.
  [[nodiscard]] bool contains(const AxisValues& q) const;
  /// Sets the efforts and weights of axes without a motor to exactly 0. Shortens the efforts of the handle, all alike,
  /// until none is beyond its limit, and that of the gripper by itself; where one is not finite, all are 0. Returns
  /// whether any was shortened. Others stay as they are, to the last bit.
  bool shorten(LinkCommand& command) const;
};

/// Throws InputError where the axes cannot be: none or too many of them, a gripper that is not the last one or a second
/// one, a pose of other than three or six axes, a limit that is not finite.
void check(const AxisLimits& limits);

}  // namespace tactor
