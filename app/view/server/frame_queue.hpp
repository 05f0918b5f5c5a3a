// What waits for one page: chunks that join into frames, as many ahead as it has drawn.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>

namespace tactor {

/// The frames of one page. It may have `most_ahead` frames that it has not acknowledged; what comes meanwhile waits, in
/// bounds, and goes with the next frame. A browser that was blocked so finds a second of samples and no backlog.
class FrameQueue {
 public:
  static constexpr std::uint64_t most_ahead = 8;
  static constexpr std::size_t most_chunks = 64;  // more than a second of the server's chunks
  static constexpr std::size_t most_bytes = std::size_t{1} << 20U;

  /// The oldest chunk goes where there is no room.
  void add(std::shared_ptr<const std::string> chunk);
  /// The page has drawn the frame. False where it was never sent.
  bool acknowledge(std::uint64_t frame);
  /// Whether the page may have a frame now.
  [[nodiscard]] bool has_credit() const { return sent_ - acknowledged_ < most_ahead; }
  /// The next frame, of all that waits; nothing where nothing waits or the page has not drawn enough.
  [[nodiscard]] std::optional<std::string> next();
  /// The number of a frame that is sent without waiting here, where the page may have one.
  [[nodiscard]] std::optional<std::uint64_t> take_number() {
    return has_credit() ? std::optional(++sent_) : std::nullopt;
  }
  /// Chunks that the page did not get.
  [[nodiscard]] std::uint64_t dropped() const { return dropped_; }

 private:
  std::deque<std::shared_ptr<const std::string>> waiting_;
  std::size_t bytes_ = 0;
  std::uint64_t sent_ = 0, acknowledged_ = 0, dropped_ = 0;
};

}  // namespace tactor
