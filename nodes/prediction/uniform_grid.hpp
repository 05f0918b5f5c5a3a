// A stream of unevenly stamped samples, read at even times.
#pragma once

#include "framework/core/between_samples.hpp"
#include "framework/core/messages.hpp"
#include "framework/core/period_estimate.hpp"

namespace tactor {

/// Linear interpolation of a stream at times one estimated period apart, the mean of the last 64 intervals. The times
/// follow the estimate as it changes. After a pause, more than 16 periods, the grid starts anew at the sample behind
/// it. A sample that is not later than the one before is left out.
class UniformGrid {
 public:
  void push(const Stamped<Wrench>& sample) {
    if (any_ && sample.stamp.valid <= newest_.stamp.valid) return;
    const bool pause = (sample.stamp.valid - newest_.stamp.valid).ns / longest_gap > period_.value().ns;
    period_.update(sample.stamp.valid);
    if (!any_ || pause) next_ = sample.stamp.valid;
    before_ = any_ && !pause ? newest_ : sample;
    newest_ = sample;
    any_ = true;
  }
  /// Reads the next value of the grid that lies no later than the newest sample; false where there is none.
  bool next(Stamped<Wrench>& out) {
    if (!any_ || next_ > newest_.stamp.valid) return false;
    const bool is_line = newest_.stamp.valid > before_.stamp.valid;
    const double share = is_line ? share_between(before_.stamp.valid, newest_.stamp.valid, next_) : 1.0;
    out.stamp = {next_, newest_.stamp.produced, newest_.stamp.sequence};
    out.value = between(before_.value, newest_.value, share);
    next_ = next_ + period_.value();
    return true;
  }
  [[nodiscard]] Duration period() const { return period_.value(); }

 private:
  static constexpr std::int64_t longest_gap = 16;
  PeriodEstimate period_{{.period_estimate = PeriodMode::mean, .period_count = PeriodEstimate::max_count}};
  Stamped<Wrench> before_;
  Stamped<Wrench> newest_;
  Time next_;
  bool any_ = false;
};

}  // namespace tactor
