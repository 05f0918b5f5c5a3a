// A causal estimate of the period at which stamped messages come, from the stamps alone.
#pragma once

#include <algorithm>
#include <array>

#include "framework/core/check.hpp"
#include "framework/core/time.hpp"

namespace tactor {

/// How the next period is estimated from the intervals seen so far.
enum class PeriodMode {
  last,  ///< the last interval
  mean,  ///< the mean of the last `count` intervals
};

/// The choices of a period estimate.
struct PeriodOptions {
  PeriodMode period_estimate = PeriodMode::last;
  std::int32_t period_count = 8;  ///< intervals in the mean, 1 to 64
  Duration period_initial{10'000'000};
  Duration period_max{100'000'000};  ///< an interval beyond it (a pause) counts as this long
};

/// Follows the stamps of one stream. A stamp that is not later than the one before is left out.
class PeriodEstimate {
 public:
  static constexpr std::int32_t max_count = 64;

  explicit PeriodEstimate(const PeriodOptions& options) : options_(options) {
    TACTOR_DEMAND(options.period_count >= 1 && options.period_count <= max_count);
  }

  void update(Time stamp) {
    if (stamps_ > 0 && stamp <= last_) return;
    if (stamps_ > 0) {
      intervals_[static_cast<std::size_t>((stamps_ - 1) % options_.period_count)] =
          std::min(stamp - last_, options_.period_max);
    }
    last_ = stamp;
    ++stamps_;
  }

  /// The period expected next; `period_initial` before the second stamp. Always above zero.
  [[nodiscard]] Duration value() const {
    if (stamps_ < 2) return std::max(options_.period_initial, Duration{1});
    const std::int64_t intervals = stamps_ - 1;
    if (options_.period_estimate == PeriodMode::last) {
      return intervals_[static_cast<std::size_t>((intervals - 1) % options_.period_count)];
    }
    const std::int64_t used = std::min<std::int64_t>(intervals, options_.period_count);
    Duration sum;
    for (std::int64_t i = 0; i < used; ++i) sum += intervals_[static_cast<std::size_t>(i)];
    return std::max(Duration{sum.ns / used}, Duration{1});
  }

 private:
  PeriodOptions options_;
  std::array<Duration, max_count> intervals_{};
  std::int64_t stamps_ = 0;
  Time last_;
};

}  // namespace tactor
