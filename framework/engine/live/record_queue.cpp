#include "framework/engine/live/record_queue.hpp"

#include <cstring>
#include <exception>
#include <mutex>

namespace tactor {

RecordQueue::~RecordQueue() {
  hand_on(bytes_, nullptr);
}

void RecordQueue::put_message(std::size_t stream, const Stamp& stamp, const void* payload, const MessageType& type) {
  put({stream, stamp, &type}, payload);
}

void RecordQueue::put_step(std::size_t node, Time now, Duration cost) {
  put({node, {now, now + cost, 0}, nullptr}, nullptr);
}

void RecordQueue::put(const Head& head, const void* payload) {
  const std::size_t size = head.type == nullptr ? 0 : head.type->size;
  const std::scoped_lock lock(mutex_);
  const std::size_t begin = bytes_.size();
  if (begin + sizeof head + size > capacity_) {
    ++dropped_;
    return;
  }
  bytes_.resize(begin + sizeof head + size);
  std::memcpy(bytes_.data() + begin, &head, sizeof head);
  if (head.type == nullptr) return;
  std::memcpy(bytes_.data() + begin + sizeof head, payload, size);
  retain(*head.type, payload);
}

void RecordQueue::drain(RunObserver& observer) {
  {
    const std::scoped_lock lock(mutex_);
    taken_.swap(bytes_);
    bytes_.clear();
  }
  hand_on(taken_, &observer);
}

void RecordQueue::hand_on(std::vector<std::byte>& bytes, RunObserver* observer) {
  std::exception_ptr failed;
  for (std::size_t at = 0; at < bytes.size();) {
    Head head;
    std::memcpy(&head, bytes.data() + at, sizeof head);
    at += sizeof head;
    std::byte* payload = bytes.data() + at;
    if (observer != nullptr && failed == nullptr) try {
        if (head.type == nullptr) {
          observer->on_step(head.index, head.stamp.valid, head.stamp.produced - head.stamp.valid);
        } else {
          observer->on_message(head.index, head.stamp, payload);
        }
      } catch (...) {
        failed = std::current_exception();
      }
    if (head.type == nullptr) continue;
    release(*head.type, payload);
    at += head.type->size;
  }
  bytes.clear();
  if (failed) std::rethrow_exception(failed);
}

std::uint64_t RecordQueue::dropped() {
  const std::scoped_lock lock(mutex_);
  return dropped_;
}

}  // namespace tactor
