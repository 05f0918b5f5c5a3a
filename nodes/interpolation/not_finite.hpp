// What interpolations that start from the displayed curve do with a force that is not finite.
#pragma once

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

}  // namespace tactor
