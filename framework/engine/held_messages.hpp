// Messages that an engine keeps until they may go on, first in first out.
#pragma once

#include <cstddef>
#include <cstring>
#include <vector>

#include "framework/core/check.hpp"
#include "framework/core/message.hpp"

namespace tactor {

/// A queue that loses nothing. Its memory grows to what was needed at most and is used again, so that nothing is
/// allocated once a run is under way.
class HeldMessages {
 public:
  /// `size`: bytes of a message's value.
  explicit HeldMessages(std::size_t size = 0) : size_(size) { grow(4); }

  [[nodiscard]] bool empty() const { return count_ == 0; }
  [[nodiscard]] std::size_t count() const { return count_; }

  void push(const Stamp& stamp, const void* value) {
    if (count_ == stamps_.size()) grow(2 * count_);
    const std::size_t place = (first_ + count_++) % stamps_.size();
    stamps_[place] = stamp;
    if (size_ > 0) std::memcpy(values_.data() + place * size_, value, size_);
  }
  /// The oldest; until the next push.
  [[nodiscard]] Stamp& stamp() { return stamps_[first_]; }
  [[nodiscard]] const std::byte* value() const { return values_.data() + first_ * size_; }
  void pop() {
    TACTOR_ASSERT(count_ > 0);
    first_ = (first_ + 1) % stamps_.size();
    --count_;
  }

 private:
  void grow(std::size_t capacity) {
    std::vector<Stamp> stamps(capacity);
    std::vector<std::byte> values(capacity * size_);
    for (std::size_t i = 0; i < count_; ++i) {
      const std::size_t place = (first_ + i) % stamps_.size();
      stamps[i] = stamps_[place];
      if (size_ > 0) std::memcpy(values.data() + i * size_, values_.data() + place * size_, size_);
    }
    stamps_ = std::move(stamps);
    values_ = std::move(values);
    first_ = 0;
  }

  std::size_t size_;
  std::vector<Stamp> stamps_;
  std::vector<std::byte> values_;
  std::size_t first_ = 0, count_ = 0;
};

}  // namespace tactor
