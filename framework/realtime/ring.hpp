// A bounded queue of stamped records from one thread to another that never waits and counts what it drops.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "framework/core/cache_lines.hpp"
#include "framework/core/check.hpp"
#include "framework/core/message.hpp"

namespace tactor {

/// What stands before a record's payload.
struct RecordHeader {
  std::int32_t port = 0;   ///< whose output it is; a number the two ends agree on
  std::uint32_t size = 0;  ///< bytes of payload
  std::int64_t tick = 0;   ///< the tick of the loop that made it
  Stamp stamp;
};

/// A wait-free ring for one producer thread and one consumer thread.
///
/// Storage is allocated and touched by the constructor. `push` and `pop` allocate nothing and take no lock; a record
/// that finds the ring full is dropped (the newest, so that what is read has no gap before it) and counted.
class Ring {
 public:
  /// Holds up to `capacity` records, at least 1, with payloads of up to `max_payload` bytes.
  Ring(std::size_t capacity, std::size_t max_payload)
      : capacity_(capacity), max_payload_(max_payload), records_(capacity, sizeof(RecordHeader) + max_payload) {
    TACTOR_DEMAND(capacity >= 1);
  }

  [[nodiscard]] std::size_t capacity() const { return capacity_; }
  [[nodiscard]] std::size_t max_payload() const { return max_payload_; }

  /// Producer: appends a record of `header.size` bytes of payload. False where the ring is full; then it counts a drop.
  bool push(const RecordHeader& header, const void* payload) noexcept {
    TACTOR_ASSERT(header.size <= max_payload_);
    const std::uint64_t tail = tail_.load(std::memory_order_relaxed);
    if (tail - head_seen_ == capacity_) {
      head_seen_ = head_.load(std::memory_order_acquire);
      if (tail - head_seen_ == capacity_) {
        drops_.store(drops_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
        return false;
      }
    }
    std::byte* record = records_[tail % capacity_];
    std::memcpy(record, &header, sizeof header);
    if (header.size > 0) std::memcpy(record + sizeof header, payload, header.size);
    tail_.store(tail + 1, std::memory_order_release);
    return true;
  }

  /// Consumer: takes the oldest record; `payload` has room for `max_payload` bytes. False where the ring is empty.
  [[nodiscard]] bool pop(RecordHeader& header, void* payload) noexcept {
    const std::uint64_t head = head_.load(std::memory_order_relaxed);
    if (head == tail_seen_) {
      tail_seen_ = tail_.load(std::memory_order_acquire);
      if (head == tail_seen_) return false;
    }
    const std::byte* record = records_[head % capacity_];
    std::memcpy(&header, record, sizeof header);
    if (header.size > 0) std::memcpy(payload, record + sizeof header, header.size);
    head_.store(head + 1, std::memory_order_release);
    return true;
  }

  /// Any thread: the records that found the ring full.
  [[nodiscard]] std::uint64_t drops() const noexcept { return drops_.load(std::memory_order_relaxed); }

 private:
  std::size_t capacity_;
  std::size_t max_payload_;
  CacheLines records_;
  // Each end keeps what it last saw of the other, and so reads the other's line only when the ring looks full or empty.
  alignas(cache_line) std::atomic<std::uint64_t> tail_{0};  ///< records pushed
  std::uint64_t head_seen_ = 0;
  std::atomic<std::uint64_t> drops_{0};
  alignas(cache_line) std::atomic<std::uint64_t> head_{0};  ///< records popped
  std::uint64_t tail_seen_ = 0;
};

}  // namespace tactor
