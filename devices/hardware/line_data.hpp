// What passes between a device loop and the line of a device: plain data of fixed size.
#pragma once

#include <array>
#include <cstdint>
#include <limits>

#include "framework/core/messages.hpp"
#include "framework/core/spatial.hpp"
#include "framework/core/time.hpp"
#include "framework/realtime/axis_values.hpp"

namespace tactor {

/// The most values of the kind that `StatusInfo` describes.
inline constexpr int max_status = HardwareStatus::capacity;

/// What an axis of a device is for.
enum class AxisRole : std::uint8_t {
  pose,     ///< moves the handle, and has a motor
  sensed,   ///< moves the handle, and has no motor: its effort is exactly 0
  gripper,  ///< opens the gripper, and has a motor; grows as it opens
};

/// What a device is to do: an effort an axis, N where the axis slides and N m where it turns, on the device, in the
/// direction in which its coordinate grows. A device that takes a wrench has the force on axes 0 to 2 and the torque on
/// axes 3 to 5, in its base B, about the handle.
struct LinkCommand {
  AxisValues effort{};
  AxisValues weight{};   ///< the part of it that displays the tool's weight, whose energy is not counted
  Duration return_time;  ///< from zero to all of it by the slew limits of the gate, after it had expired
  [[nodiscard]] bool is_zero() const { return effort == AxisValues{}; }
};

/// What a device shows of itself.
struct LinkSample {
  AxisValues q{};             ///< m where the axis slides, rad where it turns
  Quat R_BD;                  ///< of the handle in the base, unit; of meaning where AxisLimits::turns
  std::uint32_t buttons = 0;  ///< one bit a button that is held
  std::uint32_t faults = 0;   ///< bits of a fault that the device itself reports, as the link numbers them; 0: none
  std::array<double, max_status> status{};  ///< in the order of the device's list of StatusInfo
};

/// What a line knows of its device's limits when it is open. Infinite: it does not know.
struct LinkLimits {
  static constexpr double unknown = std::numeric_limits<double>::infinity();
  AxisValues effort_max = every_axis(unknown);  ///< N or N m, of the device
  AxisValues speed_max = every_axis(unknown);   ///< m/s or rad/s
  AxisValues q_min = every_axis(-unknown);      ///< m or rad, the end of the workspace
  AxisValues q_max = every_axis(unknown);       ///< m or rad
};

}  // namespace tactor
