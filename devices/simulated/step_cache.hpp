// What is made for one length of step, kept for the lengths that come again.
#pragma once

#include <array>
#include <cstddef>

namespace tactor {

/// A loop has few lengths of step: one, or two in turn where its period is no whole number of nanoseconds, and others
/// after ticks that it missed. What was made for the last four of them is kept.
template <class T>
class StepCache {
 public:
  /// What `make(h, value)` makes for steps of `h` > 0 s. The reference holds until the next call.
  template <class Make>
  const T& get(double h, const Make& make) {
    for (const Entry& entry : entries_) {
      if (entry.h == h) return entry.value;
    }
    Entry& oldest = entries_[next_];
    next_ = (next_ + 1) % entries_.size();
    oldest.h = h;
    make(h, oldest.value);
    return oldest.value;
  }

 private:
  struct Entry {
    double h = 0;  // s; 0: none yet
    T value{};
  };
  std::array<Entry, 4> entries_{};
  std::size_t next_ = 0;
};

}  // namespace tactor
