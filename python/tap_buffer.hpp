// What a tap has taken out of a run and Python has not asked for yet.
#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <vector>

#include "framework/core/message.hpp"

namespace tactor::python {

/// Messages in a row. Any thread.
class TapBuffer {
 public:
  /// `most`: how many may wait, of which the oldest goes; 0: as many as come. `type` outlives the buffer.
  TapBuffer(const MessageType& type, std::size_t most);
  TapBuffer(const TapBuffer&) = delete;
  TapBuffer& operator=(const TapBuffer&) = delete;
  ~TapBuffer() { close(); }

  [[nodiscard]] const MessageType& type() const { return type_; }
  /// A message of the run. Its SharedArrays are copied, because the run has few of them.
  void put(const Stamp& stamp, const void* value);
  /// Everything that waits, oldest first, as MessageArrays::take wants it.
  std::vector<std::byte> take();
  /// Messages that went because too many waited.
  [[nodiscard]] std::uint64_t dropped() const;
  /// Lets go of what waits, and takes nothing more.
  void close();

 private:
  std::byte* place();  // of the next message

  const MessageType& type_;
  const std::size_t most_, value_offset_, size_;
  std::vector<std::size_t> array_bytes_;  // of one element of each array
  mutable std::mutex mutex_;
  std::vector<std::byte> bytes_;
  std::size_t oldest_ = 0;  // where `most` wait: the message that is replaced next
  std::uint64_t dropped_ = 0;
  bool closed_ = false;
};

}  // namespace tactor::python
