// The queue of an edge: bounded, of stamped messages, with the edge's policy, between one writer and one reader.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "framework/core/cache_lines.hpp"
#include "framework/core/check.hpp"
#include "framework/core/message.hpp"

namespace tactor {

/// What an edge does with messages that its reader has not taken yet.
enum class QueuePolicy : std::uint8_t {
  latest,       ///< one place; a newer message replaces an older one
  drop_oldest,  ///< a bounded queue; when full the oldest goes
  drop_newest,  ///< a bounded queue; when full the arriving one goes
  block,        ///< a bounded queue; when full the writer waits
};

/// A policy with its bound.
struct Queue {
  QueuePolicy policy = QueuePolicy::latest;
  std::uint32_t capacity = 1;
};

/// A message where the queue keeps it: its stamp, and its value behind that. The same layout as Stamped<T>.
struct MessageView {
  const Stamp* stamp = nullptr;
  const std::byte* value = nullptr;
  explicit operator bool() const { return stamp != nullptr; }
};

/// One queue for every edge, wherever its ends are.
///
/// A message takes two steps. `push` adds it to the arrived messages. `admit` passes these on to the reader, who then
/// sees them by `newest` and `take`. So a step sees the messages that had arrived when it began, and no later ones.
/// Both sides hold up to `capacity` messages, by the policy: a message at a full queue replaces the oldest arrived one
/// or is refused, and the same happens when it is admitted. A lost message is counted once.
///
/// One thread may push while another one does everything else; neither waits, locks or allocates. `push` copies the
/// message once; after that, only the number of its place is passed on. The writer takes the oldest arrived message
/// back by a compare-and-swap on the counter by which the reader takes messages. Either side must try again only if the
/// other one has just got a message.
///
/// All storage is made and touched by the constructor.
class EdgeQueue {
 public:
  /// `type` of the messages must outlive the queue. The capacity of a `latest` queue is 1.
  EdgeQueue(const MessageType& type, Queue queue) : EdgeQueue(type.size, type.alignment, queue) { type_ = &type; }
  /// For values that are not messages; `size` and `alignment` in bytes.
  EdgeQueue(std::size_t size, std::size_t alignment, Queue queue)
      : queue_(queue),
        capacity_(queue.policy == QueuePolicy::latest ? 1 : queue.capacity),
        places_(place_count(capacity_)),
        size_(size),
        offset_((sizeof(Stamp) + alignment - 1) / alignment * alignment),
        buffers_(places_, offset_ + size),
        arrived_(capacity_),
        free_(places_),
        admitted_(capacity_) {
    TACTOR_DEMAND(queue.capacity >= 1);
    // Place 0 is the writer's; the others are free.
    for (std::size_t place = 1; place < places_; ++place) free_[place - 1].store(static_cast<std::uint32_t>(place));
    free_tail_.store(places_ - 1);
  }
  EdgeQueue(const EdgeQueue&) = delete;
  EdgeQueue& operator=(const EdgeQueue&) = delete;
  ~EdgeQueue() {
    for (std::size_t place = 0; type_ != nullptr && place < places_; ++place) {
      release(*type_, buffers_[place] + offset_);
    }
  }

  [[nodiscard]] const Queue& queue() const { return queue_; }

  // The writer.

  /// Takes a message in by the policy. False where it was refused: the queue is full and its policy is `drop_newest`,
  /// or `block`, for which the writer is to wait.
  bool push(const Stamp& stamp, const void* value) noexcept {
    std::uint64_t tail = tail_.load(std::memory_order_relaxed);
    std::uint32_t spare = none;
    if (tail - head_.load(std::memory_order_acquire) >= capacity_) {
      switch (queue_.policy) {
        case QueuePolicy::block:
          return false;
        case QueuePolicy::drop_newest:
          count(lost_);
          return false;
        case QueuePolicy::latest:
        case QueuePolicy::drop_oldest:
          spare = take_back(tail - capacity_);
          if (spare != none) count(queue_.policy == QueuePolicy::latest ? superseded_ : lost_);
      }
    }
    std::byte* buffer = buffers_[writing_];
    std::memcpy(buffer, &stamp, sizeof stamp);
    // The arrays of the message that was here go back to their pool now, by the writer.
    if (type_ != nullptr) release(*type_, buffer + offset_);
    std::memcpy(buffer + offset_, value, size_);
    if (type_ != nullptr) retain(*type_, value);
    arrived_[tail % capacity_].store(writing_, std::memory_order_relaxed);
    tail_.store(tail + 1, std::memory_order_release);
    writing_ = spare != none ? spare : take_free();
    return true;
  }

  /// Messages that have arrived and that the reader has not admitted; for other threads than the writer, where it was
  /// true a moment ago.
  [[nodiscard]] std::size_t arrived() const noexcept {
    const std::uint64_t head = head_.load(std::memory_order_acquire);
    return static_cast<std::size_t>(tail_.load(std::memory_order_acquire) - head);
  }

  // The reader.

  /// Lets the reader see the arrived messages that were produced up to the time `by`, in order. The first newer one
  /// waits, and so do those after it.
  void admit(Time by = latest_time) noexcept {
    while (queue_.policy != QueuePolicy::block || unread_ < capacity_) {
      if (ahead_ == none) ahead_ = next_arrived();
      // Only who owns a message may look at it, so the first that is too new is kept, where nothing can replace it.
      if (ahead_ == none || stamp_of(ahead_).produced > by) return;
      admit_one(ahead_);
      ahead_ = none;
    }
  }

  /// Messages that were admitted and not taken.
  [[nodiscard]] std::size_t unread() const noexcept { return unread_; }
  /// A `latest` message has been looked at.
  void mark_seen() noexcept {
    if (queue_.policy == QueuePolicy::latest) unread_ = 0;
  }
  /// The newest message that was admitted, taken or not; until the next call of `admit` or `take`.
  [[nodiscard]] MessageView newest() const noexcept { return newest_ == none ? MessageView{} : view(newest_); }
  /// The oldest message that was admitted and not taken; until the next call of `admit` or `take`.
  [[nodiscard]] MessageView take() noexcept {
    if (unread_ == 0) return {};
    const std::uint32_t place = admitted_[first_ % capacity_];
    ++first_;
    --unread_;
    if (taken_ != none && taken_ != newest_) give_back(taken_);
    taken_ = place;
    return view(place);
  }

  // Any thread.

  /// Messages lost because the queue was full.
  [[nodiscard]] std::uint64_t dropped() const noexcept {
    return lost_.load(std::memory_order_relaxed) + lost_at_reader_.load(std::memory_order_relaxed);
  }
  /// Messages of a `latest` edge that a newer one replaced before the reader looked.
  [[nodiscard]] std::uint64_t superseded() const noexcept {
    return superseded_.load(std::memory_order_relaxed) + superseded_at_reader_.load(std::memory_order_relaxed);
  }

 private:
  static constexpr std::uint32_t none = ~std::uint32_t{0};
  static constexpr Time latest_time{INT64_MAX};

  /// Those that have arrived, those that were admitted, and one each: being written, ahead of the reader's time, taken
  /// last, newest.
  static std::size_t place_count(std::size_t capacity) { return 2 * capacity + 4; }
  static void count(std::atomic<std::uint64_t>& counter) noexcept {
    // Each counter has one writer.
    counter.store(counter.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  }

  [[nodiscard]] const Stamp& stamp_of(std::uint32_t place) const noexcept {
    return *reinterpret_cast<const Stamp*>(buffers_[place]);
  }
  [[nodiscard]] MessageView view(std::uint32_t place) const noexcept {
    return {&stamp_of(place), buffers_[place] + offset_};
  }

  using Numbers = std::vector<std::atomic<std::uint32_t>>;

  /// The writer: the oldest message that has arrived, which is number `at`; `none` where the reader has just got it.
  std::uint32_t take_back(std::uint64_t at) noexcept {
    const std::uint32_t place = arrived_[at % capacity_].load(std::memory_order_relaxed);
    return head_.compare_exchange_strong(at, at + 1, std::memory_order_acq_rel) ? place : none;
  }
  /// The reader: the oldest message that has arrived; `none` where there is none.
  std::uint32_t next_arrived() noexcept {
    std::uint64_t at = head_.load(std::memory_order_acquire);
    while (at < tail_.load(std::memory_order_acquire)) {
      const std::uint32_t place = arrived_[at % capacity_].load(std::memory_order_relaxed);
      // Where it fails the writer has taken that message back, and `at` is read anew.
      if (head_.compare_exchange_strong(at, at + 1, std::memory_order_acq_rel)) return place;
    }
    return none;
  }

  /// The writer: a place to write the next message to. There is one, because there are more places than are in use.
  std::uint32_t take_free() noexcept {
    const std::uint64_t head = free_head_;
    // What the reader did with the place happened before this.
    const std::uint64_t tail = free_tail_.load(std::memory_order_acquire);
    TACTOR_DEMAND(head < tail);
    const std::uint32_t place = free_[head % places_].load(std::memory_order_relaxed);
    free_head_ = head + 1;
    return place;
  }
  /// The reader: a place that nobody looks at any more.
  void give_back(std::uint32_t place) noexcept {
    const std::uint64_t tail = free_tail_.load(std::memory_order_relaxed);
    free_[tail % places_].store(place, std::memory_order_relaxed);
    free_tail_.store(tail + 1, std::memory_order_release);
  }

  void admit_one(std::uint32_t place) noexcept {
    if (queue_.policy == QueuePolicy::latest) {
      if (unread_ > 0) count(superseded_at_reader_);
      first_ += unread_;
      unread_ = 0;
    } else if (unread_ == capacity_) {
      count(lost_at_reader_);
      if (queue_.policy == QueuePolicy::drop_newest) {
        give_back(place);
        return;
      }
      const std::uint32_t oldest = admitted_[first_ % capacity_];
      ++first_;
      --unread_;
      if (oldest != newest_) give_back(oldest);
    }
    // The one that was newest stays where it still waits or was taken last.
    if (newest_ != none && newest_ != taken_ && unread_ == 0) give_back(newest_);
    newest_ = place;
    admitted_[(first_ + unread_) % capacity_] = place;
    ++unread_;
  }

  const MessageType* type_ = nullptr;
  Queue queue_;
  std::size_t capacity_;
  std::size_t places_;
  std::size_t size_;    // of a value
  std::size_t offset_;  // of the value behind the stamp
  CacheLines buffers_;

  Numbers arrived_;
  Numbers free_;
  alignas(cache_line) std::atomic<std::uint64_t> tail_{0};  // arrived, by the writer
  std::uint32_t writing_ = 0;                               // the writer's place
  std::atomic<std::uint64_t> lost_{0}, superseded_{0};      // counted by the writer
  std::uint64_t free_head_ = 0;                             // free places taken
  alignas(cache_line) std::atomic<std::uint64_t> head_{0};  // admitted or taken back, by both
  alignas(cache_line) std::atomic<std::uint64_t> free_tail_{0};
  std::atomic<std::uint64_t> lost_at_reader_{0}, superseded_at_reader_{0};
  std::vector<std::uint32_t> admitted_;  // the reader's, from first_ on
  std::uint64_t first_ = 0;
  std::size_t unread_ = 0;
  std::uint32_t newest_ = none, taken_ = none, ahead_ = none;
};

}  // namespace tactor
