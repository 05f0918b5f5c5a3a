// The newest value from one process to another, in memory that both have: whoever dies in the middle leaves the other
// one with whole values.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace tactor {

/// Of the bytes of a record and its number. It finds what was torn or written over by accident; it is no protection
/// against a program that wants to deceive. `size` is a multiple of 8.
inline std::uint64_t record_sum(const std::byte* bytes, std::size_t size, std::uint64_t sequence) noexcept {
  std::uint64_t sum = 0xcbf29ce484222325U ^ sequence;
  for (std::size_t at = 0; at < size; at += sizeof sum) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes + at, sizeof word);
    sum = (sum ^ word) * 0x9e3779b97f4a7c15U;
    sum ^= sum >> 29U;
  }
  return sum;
}

/// Three places for a value: one belongs to the writer, one to the reader, and one is between them. It lies in shared
/// memory. Neither side believes anything in it: a number of a place is checked, and so is the sum of a record.
template <class T>
class SharedSlot {
  static_assert(std::is_trivially_copyable_v<T> && sizeof(T) % sizeof(std::uint64_t) == 0);

 public:
  struct Record {
    std::array<std::byte, sizeof(T)> value;
    std::uint64_t sequence;
    std::uint64_t sum;
  };
  alignas(64) std::array<Record, 3> places{};
  /// The number of the place between the two, and whether its record has not been read.
  alignas(64) std::atomic<std::uint32_t> between{1};

  static constexpr std::uint32_t unread = 4;
  static constexpr std::uint32_t number = 3;
};

/// The side of a SharedSlot that writes; one thread. Wait-free.
template <class T>
class SlotWriter {
 public:
  explicit SlotWriter(SharedSlot<T>& slot) : slot_(slot) {}
  void put(const T& value) noexcept {
    auto& record = slot_.places[mine_];
    std::memcpy(record.value.data(), &value, sizeof value);
    record.sequence = ++sequence_;
    record.sum = record_sum(record.value.data(), sizeof value, sequence_);
    const std::uint32_t got = slot_.between.exchange(mine_ | slot_.unread, std::memory_order_acq_rel) & slot_.number;
    mine_ = got < slot_.places.size() ? got : (mine_ + 1) % 3;
  }

 private:
  SharedSlot<T>& slot_;
  std::uint32_t mine_ = 0;
  std::uint64_t sequence_ = 0;
};

/// What a reader finds.
enum class SlotFound : std::uint8_t {
  nothing,  ///< nothing since the last time
  value,
  damaged,  ///< a record that is not whole, or an older one than was read before; it is not used
};

/// The side of a SharedSlot that reads; one thread. Wait-free.
template <class T>
class SlotReader {
 public:
  explicit SlotReader(SharedSlot<T>& slot) : slot_(slot) {}
  /// `value` is set where a value was found, and else left alone.
  SlotFound take(T& value) noexcept {
    if ((slot_.between.load(std::memory_order_relaxed) & slot_.unread) == 0) return SlotFound::nothing;
    const std::uint32_t got = slot_.between.exchange(mine_, std::memory_order_acq_rel) & slot_.number;
    if (got >= slot_.places.size()) {
      mine_ = (mine_ + 1) % 3;
      return SlotFound::damaged;
    }
    mine_ = got;
    // Judged after it was copied: the other side could write to it meanwhile.
    typename SharedSlot<T>::Record record;
    std::memcpy(&record, &slot_.places[mine_], sizeof record);
    const bool is_whole = record.sum == record_sum(record.value.data(), sizeof value, record.sequence);
    if (!is_whole || record.sequence <= sequence_) return SlotFound::damaged;
    sequence_ = record.sequence;
    std::memcpy(&value, record.value.data(), sizeof value);
    return SlotFound::value;
  }

 private:
  SharedSlot<T>& slot_;
  std::uint32_t mine_ = 2;
  std::uint64_t sequence_ = 0;
};

}  // namespace tactor
