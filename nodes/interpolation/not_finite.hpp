// What interpolations that start from the displayed curve do with a force that is not finite.
#pragma once

#include <algorithm>
#include <initializer_list>
#include <optional>

#include "framework/core/messages.hpp"
#include "framework/core/segment.hpp"

namespace tactor {

/// The segment to send where one of the wrenches is NaN or infinite: it holds that wrench from `now` on. So the safety
/// gate sees it and faults; the caller keeps its own curve, which would otherwise never be finite again. None where all
/// are finite.
inline std::optional<ForceSegment> segment_if_not_finite(Time now, std::initializer_list<Wrench> wrenches) {
  for (const Wrench& wrench : wrenches) {
    if (!is_finite(wrench)) return constant_segment(now, wrench);
  }
  return std::nullopt;
}

/// The same for the current force and every step of a forecast.
inline std::optional<ForceSegment> segment_if_not_finite(Time now, const Forecast& forecast) {
  auto found = segment_if_not_finite(now, {forecast.current_D_W});
  for (std::int32_t i = 0; i < std::min<std::int32_t>(forecast.count, Forecast::capacity) && !found; ++i) {
    found = segment_if_not_finite(now, {forecast.predicted_D_W[static_cast<std::size_t>(i)]});
  }
  return found;
}

}  // namespace tactor
