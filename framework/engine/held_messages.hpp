// Messages that an engine keeps until they may go on, first in first out.
#pragma once

#include <cstddef>
#include <cstring>
#include <utility>
#include <vector>

#include "framework/core/check.hpp"
#include "framework/core/message.hpp"

namespace tactor {

/// A queue that loses nothing. Its memory grows to what was needed at most and is used again, so that nothing is
/// allocated once a run is under way.
class HeldMessages {
 public:
  /// `type` of the messages must outlive it.
  explicit HeldMessages(const MessageType& type) : type_(&type) { grow(4); }
  HeldMessages(HeldMessages&& other) noexcept
      : type_(other.type_),
        stamps_(std::move(other.stamps_)),
        values_(std::move(other.values_)),
        first_(other.first_),
        count_(std::exchange(other.count_, 0)) {}
  HeldMessages(const HeldMessages&) = delete;
  HeldMessages& operator=(const HeldMessages&) = delete;
  HeldMessages& operator=(HeldMessages&&) = delete;
  ~HeldMessages() {
    while (!empty()) pop();
  }

  [[nodiscard]] bool empty() const { return count_ == 0; }
  [[nodiscard]] std::size_t count() const { return count_; }

  void push(const Stamp& stamp, const void* value) {
    if (count_ == stamps_.size()) grow(2 * count_);
    const std::size_t place = (first_ + count_++) % stamps_.size();
    stamps_[place] = stamp;
    std::memcpy(values_.data() + place * type_->size, value, type_->size);
    retain(*type_, value);
  }
  /// The oldest; until the next push.
  [[nodiscard]] Stamp& stamp() { return stamps_[first_]; }
  [[nodiscard]] const std::byte* value() const { return values_.data() + first_ * type_->size; }
  void pop() {
    TACTOR_ASSERT(count_ > 0);
    release(*type_, values_.data() + first_ * type_->size);
    first_ = (first_ + 1) % stamps_.size();
    --count_;
  }

 private:
  void grow(std::size_t capacity) {
    std::vector<Stamp> stamps(capacity);
    const std::size_t size = type_->size;
    std::vector<std::byte> values(capacity * size);
    for (std::size_t i = 0; i < count_; ++i) {
      const std::size_t place = (first_ + i) % stamps_.size();
      stamps[i] = stamps_[place];
      std::memcpy(values.data() + i * size, values_.data() + place * size, size);
    }
    stamps_ = std::move(stamps);
    values_ = std::move(values);
    first_ = 0;
  }

  const MessageType* type_;
  std::vector<Stamp> stamps_;
  std::vector<std::byte> values_;
  std::size_t first_ = 0, count_ = 0;
};

}  // namespace tactor
