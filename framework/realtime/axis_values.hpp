// Values of the axes of a device.
#pragma once

#include <array>

namespace tactor {

/// The most axes a device may have.
inline constexpr int max_axes = 8;
/// A value for each axis of a device, in the order of the device; those beyond its number of axes are zero.
using AxisValues = std::array<double, max_axes>;

/// The same value for every axis.
constexpr AxisValues every_axis(double value) {
  AxisValues values{};
  for (double& one : values) one = value;
  return values;
}

}  // namespace tactor
