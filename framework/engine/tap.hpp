// A tap: the messages of one output, of one edge or of the engine itself, for who looks at a run from outside.
#pragma once

#include <atomic>
#include <functional>
#include <utility>

#include "framework/node/edge_queue.hpp"

namespace tactor {

/// A bounded queue out of a run. The engine writes, one thread at a time, and never waits; one other thread reads. What
/// finds it full goes by the policy and is counted.
class Tap {
 public:
  /// `type` outlives the tap. The policy is not `block`.
  Tap(const MessageType& type, Queue queue) : type_(type), queue_(type, never_dropped_by_the_reader(queue)) {
    TACTOR_DEMAND(queue.policy != QueuePolicy::block);
  }

  [[nodiscard]] const MessageType& type() const { return type_; }

  /// Where writer and reader are one thread: `read` is called before a message would find the queue full, and takes
  /// what is there, so that nothing is lost. It may throw.
  void when_full(std::function<void()> read) { read_ = std::move(read); }

  /// The engine: a message for the reader.
  void put(const Stamp& stamp, const void* value) {
    if (read_ && queue_.arrived() >= queue_.queue().capacity) read_();
    if (!queue_.push(stamp, value))
      refused_.store(refused_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  }

  /// The reader: the oldest message not taken yet; until the next call. Of a `latest` tap the newest, once.
  [[nodiscard]] MessageView take() {
    if (queue_.unread() == 0) queue_.admit();
    return queue_.take();
  }
  /// The reader: calls `read(stamp, value)` for each message that waits now. What comes meanwhile waits for the next
  /// call.
  template <class Read>
  void take_all(const Read& read) {
    queue_.admit();
    while (queue_.unread() > 0) {
      const MessageView message = queue_.take();
      read(*message.stamp, message.value);
    }
  }

  /// Messages lost because nobody took them in time. Any thread.
  [[nodiscard]] std::uint64_t dropped() const { return queue_.dropped() + refused_.load(std::memory_order_relaxed); }

 private:
  /// With `drop_newest` a message that has found room is never lost: what the reader cannot see yet waits.
  static Queue never_dropped_by_the_reader(Queue queue) {
    if (queue.policy == QueuePolicy::drop_newest) queue.policy = QueuePolicy::block;
    return queue;
  }

  const MessageType& type_;
  EdgeQueue queue_;
  std::atomic<std::uint64_t> refused_{0};
  std::function<void()> read_;
};

}  // namespace tactor
