// Arrays of changing size in messages: immutable, shared by all copies of a message, taken from a bounded pool.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>

#include "framework/core/check.hpp"

namespace tactor {

/// The memory of one array. Its elements follow it.
struct alignas(64) ArrayBlock {
  std::atomic<std::uint32_t> copies{0};
  std::uint32_t index = 0;            // in its pool
  std::size_t count = 0;              // elements in use
  class ArrayMemory* pool = nullptr;  // null: allocated for this array alone
  [[nodiscard]] std::byte* elements() { return reinterpret_cast<std::byte*>(this + 1); }
};

/// The untyped side of a SharedArray: a pointer to its block, or null for an empty one. A copy costs one atomic
/// increment; the last copy gives the block back to its pool, without a lock.
class SharedBytes {
 public:
  SharedBytes() = default;
  /// Takes the block, which nobody else holds.
  explicit SharedBytes(ArrayBlock* block) noexcept : block_(block) { retain(); }
  SharedBytes(const SharedBytes& other) noexcept : block_(other.block_) { retain(); }
  SharedBytes(SharedBytes&& other) noexcept : block_(std::exchange(other.block_, nullptr)) {}
  SharedBytes& operator=(const SharedBytes& other) noexcept {
    SharedBytes copy(other);
    std::swap(block_, copy.block_);
    return *this;
  }
  SharedBytes& operator=(SharedBytes&& other) noexcept {
    std::swap(block_, other.block_);
    return *this;
  }
  ~SharedBytes() { release(); }

  [[nodiscard]] std::size_t count() const noexcept { return block_ == nullptr ? 0 : block_->count; }
  [[nodiscard]] const std::byte* elements() const noexcept { return block_ == nullptr ? nullptr : block_->elements(); }

  void retain() noexcept {
    if (block_ != nullptr) block_->copies.fetch_add(1, std::memory_order_relaxed);
  }
  void release() noexcept;

 private:
  ArrayBlock* block_ = nullptr;
};
static_assert(sizeof(SharedBytes) == sizeof(void*));

/// A block for `count` elements of `size` bytes, freed with the last copy. Use it for arrays that are read from a file;
/// code that runs beside a real-time lane uses an ArrayPool.
ArrayBlock* allocate_array(std::size_t count, std::size_t size);

/// The blocks of a pool. It lives until the pool and all arrays out of it are gone.
class ArrayMemory {
 public:
  /// All memory is allocated and touched here.
  ArrayMemory(std::size_t arrays, std::size_t bytes);
  ArrayMemory(const ArrayMemory&) = delete;
  ArrayMemory& operator=(const ArrayMemory&) = delete;

  /// A free block; null if all are in use. Any thread, no lock.
  ArrayBlock* take() noexcept;
  void give_back(ArrayBlock* block) noexcept;
  /// The pool is destroyed.
  void abandon() noexcept { drop(); }

 private:
  ~ArrayMemory();
  void drop() noexcept {
    if (owners_.fetch_sub(1, std::memory_order_acq_rel) == 1) delete this;
  }
  [[nodiscard]] ArrayBlock* block(std::size_t index) noexcept {
    return reinterpret_cast<ArrayBlock*>(memory_ + index * stride_);
  }

  std::size_t arrays_;
  std::size_t stride_;
  std::byte* memory_;
  std::unique_ptr<std::atomic<std::uint32_t>[]> next_;  // of a free block: the free one below it, plus one
  std::atomic<std::uint64_t> top_;                      // the top free block plus one, and how often it has changed
  std::atomic<std::size_t> owners_{1};                  // the pool, and each block in use
};

/// An immutable array in a message. Elements are of fixed size and described.
template <class T>
class SharedArray {
  static_assert(std::is_trivially_copyable_v<T>, "the elements of a shared array are copied by bytes");

 public:
  using value_type = T;
  SharedArray() = default;
  explicit SharedArray(SharedBytes bytes) noexcept : bytes_(std::move(bytes)) {}

  [[nodiscard]] std::size_t size() const noexcept { return bytes_.count(); }
  [[nodiscard]] bool empty() const noexcept { return size() == 0; }
  [[nodiscard]] const T* data() const noexcept { return reinterpret_cast<const T*>(bytes_.elements()); }
  [[nodiscard]] const T* begin() const noexcept { return data(); }
  [[nodiscard]] const T* end() const noexcept { return data() + size(); }
  [[nodiscard]] const T& operator[](std::size_t i) const {
    TACTOR_ASSERT(i < size());
    return data()[i];
  }

 private:
  SharedBytes bytes_;
};

/// Makes arrays of up to `capacity` elements, `arrays` of them at the same time.
///
/// An edge keeps up to 2 n + 4 messages for a queue of n, so a pool needs that many arrays for each edge that carries
/// its messages, and one for the message that is being made.
template <class T>
class ArrayPool {
 public:
  ArrayPool(std::size_t arrays, std::size_t capacity)
      : capacity_(capacity), memory_(new ArrayMemory(arrays, capacity * sizeof(T))) {}
  ArrayPool(const ArrayPool&) = delete;
  ArrayPool& operator=(const ArrayPool&) = delete;
  ~ArrayPool() { memory_->abandon(); }

  [[nodiscard]] std::size_t capacity() const { return capacity_; }

  /// An array of `count` elements, written by `fill(std::span<T>)`. Empty if readers hold all arrays of the pool; the
  /// caller then leaves a message out. `count` is at most the capacity.
  template <class Fill>
  std::optional<SharedArray<T>> make(std::size_t count, const Fill& fill) {
    TACTOR_DEMAND(count <= capacity_);
    ArrayBlock* block = memory_->take();
    if (block == nullptr) return std::nullopt;
    block->count = count;
    SharedArray<T> array{SharedBytes(block)};
    fill(std::span<T>(reinterpret_cast<T*>(block->elements()), count));
    return array;
  }
  std::optional<SharedArray<T>> copy(std::span<const T> elements) {
    return make(elements.size(), [&](std::span<T> to) {
      if (!elements.empty()) std::memcpy(to.data(), elements.data(), elements.size_bytes());
    });
  }

 private:
  std::size_t capacity_;
  ArrayMemory* memory_;
};

}  // namespace tactor
