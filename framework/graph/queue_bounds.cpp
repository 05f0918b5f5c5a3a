#include "framework/graph/queue_bounds.hpp"

#include "framework/core/check.hpp"

namespace tactor {

std::string queue_trouble(const Queue& queue, const MessageType& type) {
  const auto found = [&] { return ", found " + std::to_string(queue.capacity); };
  if (queue.capacity < 1 || queue.capacity > most_queued) {
    return "expected a queue of 1 to " + std::to_string(most_queued) + " messages" + found();
  }
  const std::uint64_t each = sizeof(Stamp) + type.size;
  if (queue.policy != QueuePolicy::latest && queue.capacity > most_queue_bytes / each) {
    return "expected a queue of at most " + std::to_string(most_queue_bytes >> 20U) + " MiB, which is " +
           std::to_string(most_queue_bytes / each) + " messages " + std::string(type.name) + found();
  }
  return {};
}

void check_queue(const Queue& queue, const MessageType& type, const std::string& where) {
  if (const std::string trouble = queue_trouble(queue, type); !trouble.empty())
    throw InputError(where + ": " + trouble);
}

}  // namespace tactor
