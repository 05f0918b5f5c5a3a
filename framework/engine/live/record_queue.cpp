#include "framework/engine/live/record_queue.hpp"

#include <cstring>
#include <mutex>

namespace tactor {

void RecordQueue::put_message(std::size_t stream, const Stamp& stamp, const void* payload, std::size_t size) {
  put({stream, stamp, size, false}, payload);
}

void RecordQueue::put_step(std::size_t node, Time now, Duration cost) {
  put({node, {now, now + cost, 0}, 0, true}, nullptr);
}

void RecordQueue::put(const Head& head, const void* payload) {
  const std::scoped_lock lock(mutex_);
  const std::size_t begin = bytes_.size();
  if (begin + sizeof head + head.size > capacity_) {
    ++dropped_;
    return;
  }
  bytes_.resize(begin + sizeof head + head.size);
  std::memcpy(bytes_.data() + begin, &head, sizeof head);
  if (head.size > 0) std::memcpy(bytes_.data() + begin + sizeof head, payload, head.size);
}

void RecordQueue::drain(RunObserver& observer) {
  {
    const std::scoped_lock lock(mutex_);
    taken_.swap(bytes_);
    bytes_.clear();
  }
  for (std::size_t at = 0; at < taken_.size();) {
    Head head;
    std::memcpy(&head, taken_.data() + at, sizeof head);
    at += sizeof head;
    if (head.step) {
      observer.on_step(head.index, head.stamp.valid, head.stamp.produced - head.stamp.valid);
    } else {
      observer.on_message(head.index, head.stamp, taken_.data() + at);
    }
    at += head.size;
  }
  taken_.clear();
}

std::uint64_t RecordQueue::dropped() {
  const std::scoped_lock lock(mutex_);
  return dropped_;
}

}  // namespace tactor
