// The deadlines of a loop of constant rate, each computed from its number so that rounding never adds up.
#pragma once

#include <cmath>
#include <cstdint>

#include "framework/core/check.hpp"
#include "framework/core/time.hpp"

namespace tactor {

/// Tick k is due at k / rate, rounded to the nearest nanosecond: the instants that the virtual clock gives a node of
/// the same rate.
class TickSchedule {
 public:
  static constexpr double max_rate = 1e6;  ///< Hz

  /// `rate` in Hz, above 0 and at most `max_rate`.
  explicit TickSchedule(double rate) : rate_(rate) { TACTOR_DEMAND(rate > 0 && rate <= max_rate); }

  [[nodiscard]] double rate() const noexcept { return rate_; }
  [[nodiscard]] Time deadline(std::int64_t tick) const noexcept {
    return {std::llround(static_cast<double>(tick) * 1e9 / rate_)};
  }
  /// The last tick due at `t` or before it; negative before the first.
  [[nodiscard]] std::int64_t last_due(Time t) const noexcept {
    auto tick = static_cast<std::int64_t>(std::floor(t.seconds() * rate_));
    // The division above may land beside the deadline's rounding, by one tick at most.
    while (deadline(tick) > t) --tick;
    while (deadline(tick + 1) <= t) ++tick;
    return tick;
  }
  /// The first tick due at `t` or after it, from 0 on.
  [[nodiscard]] std::int64_t first_due(Time t) const noexcept {
    const std::int64_t last = last_due(t);
    const std::int64_t first = deadline(last) == t ? last : last + 1;
    return first < 0 ? 0 : first;
  }

 private:
  double rate_;
};

}  // namespace tactor
