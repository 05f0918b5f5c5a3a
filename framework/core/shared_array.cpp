#include "framework/core/shared_array.hpp"

#include <cstring>
#include <limits>
#include <new>

#include "framework/core/message.hpp"

namespace tactor {

namespace {

constexpr std::align_val_t block_alignment{alignof(ArrayBlock)};
constexpr std::uint64_t index_mask = 0xffffffffU;

SharedBytes& array_at(void* value, std::size_t offset) {
  return *reinterpret_cast<SharedBytes*>(static_cast<std::byte*>(value) + offset);
}

}  // namespace

ArrayBlock* allocate_array(std::size_t count, std::size_t size) {
  if (size > 0 && count > (std::numeric_limits<std::size_t>::max() - sizeof(ArrayBlock)) / size) throw std::bad_alloc();
  auto* block = new (::operator new(sizeof(ArrayBlock) + count * size, block_alignment)) ArrayBlock;
  block->count = count;
  return block;
}

void SharedBytes::release() noexcept {
  ArrayBlock* block = std::exchange(block_, nullptr);
  if (block == nullptr || block->copies.fetch_sub(1, std::memory_order_acq_rel) != 1) return;
  if (block->pool != nullptr) {
    block->pool->give_back(block);
  } else {
    block->~ArrayBlock();
    ::operator delete(block, block_alignment);
  }
}

ArrayMemory::ArrayMemory(std::size_t arrays, std::size_t bytes)
    : arrays_(arrays),
      stride_((sizeof(ArrayBlock) + bytes + alignof(ArrayBlock) - 1) / alignof(ArrayBlock) * alignof(ArrayBlock)),
      memory_(static_cast<std::byte*>(::operator new(arrays* stride_, block_alignment))),
      next_(std::make_unique<std::atomic<std::uint32_t>[]>(arrays)),
      top_(arrays) {
  TACTOR_DEMAND(arrays >= 1 && arrays < index_mask);
  std::memset(memory_, 0, arrays * stride_);
  for (std::size_t i = 0; i < arrays; ++i) {
    ArrayBlock* made = new (memory_ + i * stride_) ArrayBlock;
    made->index = static_cast<std::uint32_t>(i);
    made->pool = this;
    next_[i].store(static_cast<std::uint32_t>(i), std::memory_order_relaxed);
  }
}

ArrayMemory::~ArrayMemory() {
  for (std::size_t i = 0; i < arrays_; ++i) block(i)->~ArrayBlock();
  ::operator delete(memory_, block_alignment);
}

ArrayBlock* ArrayMemory::take() noexcept {
  std::uint64_t top = top_.load(std::memory_order_acquire);
  for (;;) {
    const std::uint64_t index = top & index_mask;
    if (index == 0) return nullptr;
    // Where another thread has taken that block meanwhile, the count of changes differs and the exchange fails.
    const std::uint64_t below = next_[index - 1].load(std::memory_order_relaxed);
    const std::uint64_t changed = ((top >> 32U) + 1) << 32U | below;
    if (top_.compare_exchange_weak(top, changed, std::memory_order_acq_rel, std::memory_order_acquire)) {
      owners_.fetch_add(1, std::memory_order_relaxed);
      return block(index - 1);
    }
  }
}

void ArrayMemory::give_back(ArrayBlock* given) noexcept {
  std::uint64_t top = top_.load(std::memory_order_relaxed);
  for (;;) {
    next_[given->index].store(static_cast<std::uint32_t>(top & index_mask), std::memory_order_relaxed);
    const std::uint64_t changed = ((top >> 32U) + 1) << 32U | (given->index + 1U);
    if (top_.compare_exchange_weak(top, changed, std::memory_order_acq_rel, std::memory_order_relaxed)) break;
  }
  drop();
}

void retain(const MessageType& type, const void* value) noexcept {
  // The count is not part of the value.
  for (const std::size_t offset : type.arrays) array_at(const_cast<void*>(value), offset).retain();
}

void release(const MessageType& type, void* value) noexcept {
  for (const std::size_t offset : type.arrays) array_at(value, offset).release();
}

}  // namespace tactor
