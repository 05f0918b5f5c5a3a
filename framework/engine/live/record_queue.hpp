// What happened in a live run, on its way to the observer that may be slow.
#pragma once

#include <cstdint>
#include <vector>

#include "framework/engine/live/priority_mutex.hpp"
#include "framework/engine/run_observer.hpp"

namespace tactor {

/// A bounded queue of messages and steps. Many threads put in and never wait for a disk; one takes out. What finds it
/// full is dropped and counted.
class RecordQueue {
 public:
  /// Holds up to `capacity` bytes.
  explicit RecordQueue(std::size_t capacity) : capacity_(capacity) {}
  /// Makes room for `bytes` now, so that it is not made while others wait for the lock.
  void reserve(std::size_t bytes) {
    bytes_.reserve(bytes);
    taken_.reserve(bytes);
  }

  ~RecordQueue();

  /// `type` outlives the queue.
  void put_message(std::size_t stream, const Stamp& stamp, const void* payload, const MessageType& type);
  void put_step(std::size_t node, Time now, Duration cost);
  /// Hands everything that is there to the observer; its exceptions pass, and what they cut off is lost.
  void drain(RunObserver& observer);
  /// Messages and steps that were dropped.
  [[nodiscard]] std::uint64_t dropped();

 private:
  struct Head {
    std::uint64_t index = 0;            // of the stream, or of the node
    Stamp stamp;                        // of a step: valid is its time, produced when it had passed
    const MessageType* type = nullptr;  // null: a step
  };
  void put(const Head& head, const void* payload);
  /// Hands what is in `bytes` to the observer, or to nobody, and empties it.
  static void hand_on(std::vector<std::byte>& bytes, RunObserver* observer);

  const std::size_t capacity_;
  PriorityMutex mutex_;
  std::vector<std::byte> bytes_;
  std::vector<std::byte> taken_;
  std::uint64_t dropped_ = 0;
};

}  // namespace tactor
