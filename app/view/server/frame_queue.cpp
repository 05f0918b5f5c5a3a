#include "app/view/server/frame_queue.hpp"

#include <algorithm>
#include <utility>

#include "app/view/samples.hpp"

namespace tactor {

void FrameQueue::add(std::shared_ptr<const std::string> chunk) {
  bytes_ += chunk->size();
  waiting_.push_back(std::move(chunk));
  while (waiting_.size() > most_chunks || (bytes_ > most_bytes && waiting_.size() > 1)) {
    bytes_ -= waiting_.front()->size();
    waiting_.pop_front();
    ++dropped_;
  }
}

bool FrameQueue::acknowledge(std::uint64_t frame) {
  if (frame > sent_) return false;
  acknowledged_ = std::max(acknowledged_, frame);
  return true;
}

std::optional<std::string> FrameQueue::next() {
  if (waiting_.empty() || !has_credit()) return std::nullopt;
  std::string frame = frame_header(waiting_.size(), ++sent_);
  frame.reserve(frame.size() + bytes_);
  for (const auto& chunk : waiting_) frame += *chunk;
  waiting_.clear();
  bytes_ = 0;
  return frame;
}

}  // namespace tactor
