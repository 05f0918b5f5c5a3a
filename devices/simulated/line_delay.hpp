// A line that takes time: what goes in comes out a fixed number of ticks later.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace tactor {

/// The delay as a number of ticks: the nearest whole one, because the line knows nothing of the time between two ticks.
/// Half a tick counts as one.
inline std::size_t delay_in_ticks(double delay_s, double rate_Hz) {
  return static_cast<std::size_t>(std::llround(delay_s * rate_Hz));
}

/// A ring of the last values. Allocates when it is made, and never again.
template <class T>
class LineDelay {
 public:
  /// Until a value has passed the line, `T{}` comes out, or what `fill` said.
  explicit LineDelay(std::size_t ticks) : ring_(ticks) {}

  /// All that is on the line becomes `value`.
  void fill(const T& value) noexcept {
    for (T& one : ring_) one = value;
  }
  /// Whether anything on the line is so.
  template <class Is>
  [[nodiscard]] bool any_of(const Is& is) const {
    return std::any_of(ring_.begin(), ring_.end(), is);
  }
  /// Once a tick: `value` goes in; what went in `ticks` calls before comes out.
  T pass(const T& value) noexcept {
    if (ring_.empty()) return value;
    const T oldest = ring_[next_];
    ring_[next_] = value;
    next_ = next_ + 1 == ring_.size() ? 0 : next_ + 1;
    return oldest;
  }

 private:
  std::vector<T> ring_;
  std::size_t next_ = 0;
};

}  // namespace tactor
