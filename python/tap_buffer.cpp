#include "python/tap_buffer.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "framework/core/shared_array.hpp"
#include "python/message_arrays.hpp"

namespace tactor::python {

TapBuffer::TapBuffer(const MessageType& type, std::size_t most)
    : type_(type), most_(most), value_offset_(value_offset(type)), size_(message_size(type)) {
  for (const Field* field : array_fields(type)) array_bytes_.push_back(count_of(*field) * element_size(*field));
}

std::byte* TapBuffer::place() {
  if (most_ > 0 && bytes_.size() == most_ * size_) {
    std::byte* at = bytes_.data() + oldest_ * size_;
    release(type_, at + value_offset_);
    oldest_ = (oldest_ + 1) % most_;
    ++dropped_;
    return at;
  }
  bytes_.resize(bytes_.size() + size_);
  return bytes_.data() + bytes_.size() - size_;
}

void TapBuffer::put(const Stamp& stamp, const void* value) {
  const std::scoped_lock lock(mutex_);
  if (closed_) return;
  std::byte* at = place();
  std::memcpy(at, &stamp, sizeof stamp);
  at += value_offset_;
  std::memcpy(at, value, type_.size);
  for (const std::size_t offset : type_.arrays) std::memset(at + offset, 0, sizeof(SharedBytes));
  for (std::size_t i = 0; i < array_bytes_.size(); ++i) {
    const auto& from = *reinterpret_cast<const SharedBytes*>(static_cast<const std::byte*>(value) + type_.arrays[i]);
    if (from.count() == 0) continue;
    SharedBytes copy(allocate_array(from.count(), array_bytes_[i]));
    std::memcpy(const_cast<std::byte*>(copy.elements()), from.elements(), from.count() * array_bytes_[i]);
    *reinterpret_cast<SharedBytes*>(at + type_.arrays[i]) = std::move(copy);
  }
}

std::vector<std::byte> TapBuffer::take() {
  const std::scoped_lock lock(mutex_);
  const auto first = bytes_.begin() + static_cast<std::ptrdiff_t>(oldest_ * size_);
  std::rotate(bytes_.begin(), first, bytes_.end());
  oldest_ = 0;
  return std::exchange(bytes_, {});
}

std::uint64_t TapBuffer::dropped() const {
  const std::scoped_lock lock(mutex_);
  return dropped_;
}

void TapBuffer::close() {
  const std::scoped_lock lock(mutex_);
  closed_ = true;
  for (std::size_t at = 0; at < bytes_.size(); at += size_) release(type_, bytes_.data() + at + value_offset_);
  bytes_ = {};
}

}  // namespace tactor::python
