// The newest message of a stream, handed from one thread to another without waiting.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <utility>

#include "framework/core/check.hpp"
#include "framework/core/message.hpp"
#include "framework/realtime/cache_lines.hpp"

namespace tactor {

/// A wait-free slot for one writer thread and one reader thread; a message that nobody took is replaced by the next.
///
/// The writer fills a buffer of its own and exchanges it for the one in the middle; the reader exchanges a buffer of
/// its own for the middle one. So no buffer is ever touched by both, and copying is plain memcpy. The reader owns two:
/// a message too new for this tick waits in one while a newer one is looked at in the other. With one alone, a writer
/// in step with the reader could replace each message just before its tick came, for ever.
///
/// Storage is allocated and touched by the constructor. `write` and `take` allocate nothing and take no lock.
class LatestSlot {
 public:
  /// `payload_size` in bytes, of every message; at least 1.
  explicit LatestSlot(std::size_t payload_size)
      : payload_size_(payload_size), buffers_(4, sizeof(Stamp) + payload_size) {
    TACTOR_DEMAND(payload_size >= 1);
  }

  [[nodiscard]] std::size_t payload_size() const { return payload_size_; }

  /// Writer: makes a message the newest. `stamp.produced` does not run backwards from one write to the next.
  void write(const Stamp& stamp, const void* payload) noexcept {
    std::byte* buffer = buffers_[back_];
    std::memcpy(buffer, &stamp, sizeof stamp);
    std::memcpy(buffer + sizeof stamp, payload, payload_size_);
    back_ = middle_.exchange(back_ | fresh, std::memory_order_acq_rel) & ~fresh;
  }

  /// Reader: copies the newest message with `produced` <= `by` that was not taken before. False, and nothing copied,
  /// where there is none. A message that is too new is kept for a later call, or replaced by a newer one.
  [[nodiscard]] bool take(Time by, Stamp& stamp, void* payload) noexcept {
    if ((middle_.load(std::memory_order_relaxed) & fresh) != 0) {
      spare_ = middle_.exchange(spare_, std::memory_order_acq_rel) & ~fresh;
      const bool older_fits = waiting_ && produced(front_) <= by;
      if (older_fits && produced(spare_) > by) {
        copy(front_, stamp, payload);
        std::swap(front_, spare_);
        return true;
      }
      std::swap(front_, spare_);
      waiting_ = true;
    }
    if (!waiting_ || produced(front_) > by) return false;
    copy(front_, stamp, payload);
    waiting_ = false;
    return true;
  }

 private:
  static constexpr std::uint32_t fresh = 4;  ///< beside the index in `middle_`: the reader has not had this buffer

  [[nodiscard]] Time produced(std::uint32_t buffer) const noexcept {
    Stamp stamp;
    std::memcpy(&stamp, buffers_[buffer], sizeof stamp);
    return stamp.produced;
  }
  void copy(std::uint32_t buffer, Stamp& stamp, void* payload) const noexcept {
    std::memcpy(&stamp, buffers_[buffer], sizeof stamp);
    std::memcpy(payload, buffers_[buffer] + sizeof stamp, payload_size_);
  }

  std::size_t payload_size_;
  CacheLines buffers_;
  alignas(cache_line) std::atomic<std::uint32_t> middle_{1};
  alignas(cache_line) std::uint32_t back_ = 0;   ///< the writer's
  alignas(cache_line) std::uint32_t front_ = 2;  ///< the reader's, with the message that waits
  std::uint32_t spare_ = 3;                      ///< the reader's, free
  bool waiting_ = false;                         ///< `front_` holds a message that was not taken
};

}  // namespace tactor
