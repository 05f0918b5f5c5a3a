// Blocks of bytes that share no cache line, allocated and touched at once.
#pragma once

#include <cstddef>
#include <cstring>
#include <memory>
#include <new>

namespace tactor {

/// What two cores would fight over when both write in it.
inline constexpr std::size_t cache_line = 64;

/// `count` blocks of `size` bytes, each beginning on a cache line of its own. Every page is written by the constructor,
/// so that using a block later faults none in.
class CacheLines {
 public:
  CacheLines(std::size_t count, std::size_t size)
      : stride_((size + cache_line - 1) / cache_line * cache_line),
        bytes_(static_cast<std::byte*>(::operator new (count* stride_, std::align_val_t{cache_line}))) {
    std::memset(bytes_.get(), 0, count * stride_);
  }

  [[nodiscard]] std::byte* operator[](std::size_t block) const noexcept { return bytes_.get() + block * stride_; }

 private:
  struct Free {
    void operator()(std::byte* bytes) const { ::operator delete (bytes, std::align_val_t{cache_line}); }
  };
  std::size_t stride_;
  std::unique_ptr<std::byte, Free> bytes_;
};

}  // namespace tactor
