// What waits for a viewer of Foxglove, within one bound for all viewers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <utility>

namespace tactor {

/// A message for a viewer: its own few bytes, and those that it may share with other viewers.
struct ViewerMessage {
  std::string head;
  std::shared_ptr<const std::string> body;  ///< never null
  bool binary = false;
  /// The server keeps the body anyway, for as long as it runs, so that waiting adds nothing.
  bool kept = false;

  [[nodiscard]] std::size_t bytes() const { return overhead + head.size() + (kept ? 0 : body->size()); }
  static constexpr std::size_t overhead = 128;  ///< of the queue and the heap
};

/// A queue of messages for one viewer. All are used by one thread.
class ViewerQueue {
 public:
  /// With more bytes than that waiting, samples are left out and requests are not read.
  static constexpr std::size_t most = std::size_t{1} << 20U;         ///< for one viewer
  static constexpr std::size_t most_of_all = std::size_t{4} << 20U;  ///< for all together

  /// `of_all`: bytes that wait for all viewers; it outlives the queue.
  explicit ViewerQueue(std::size_t& of_all) : of_all_(of_all) {}
  ViewerQueue(const ViewerQueue&) = delete;
  ViewerQueue& operator=(const ViewerQueue&) = delete;
  ~ViewerQueue() { of_all_ -= bytes_; }

  [[nodiscard]] bool has_room() const { return bytes_ <= most && of_all_ <= most_of_all; }
  /// For answers: no more of them are asked for than there is room for.
  void add(ViewerMessage message) {
    bytes_ += message.bytes();
    of_all_ += message.bytes();
    waiting_.push_back(std::move(message));
  }
  /// For samples: false, and the message is left out, where there is no room.
  bool add_if_room(ViewerMessage message) {
    if (!has_room()) return false;
    add(std::move(message));
    return true;
  }
  [[nodiscard]] bool empty() const { return waiting_.empty(); }
  /// The oldest message. It counts until `sent`.
  [[nodiscard]] ViewerMessage next() {
    ViewerMessage message = std::move(waiting_.front());
    waiting_.pop_front();
    return message;
  }
  void sent(const ViewerMessage& message) {
    bytes_ -= message.bytes();
    of_all_ -= message.bytes();
  }
  /// Bytes that wait, with those on their way.
  [[nodiscard]] std::size_t bytes() const { return bytes_; }

 private:
  std::size_t& of_all_;
  std::size_t bytes_ = 0;
  std::deque<ViewerMessage> waiting_;
};

}  // namespace tactor
