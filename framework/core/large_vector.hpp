// Vectors in huge pages.
#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <new>
#include <vector>

namespace tactor {

/// Takes whole huge pages (2 MB) for what fills half of one, and asks the system to make them so; where it does not,
/// the memory is as any other. Queries touch few places of large arrays: after the caches were evicted, where each page
/// of 4 kB is has to be read from memory as well.
template <class T>
struct LargeAllocator {
  using value_type = T;

  LargeAllocator() = default;
  template <class U>
  explicit LargeAllocator(const LargeAllocator<U>& /*other*/) {}

  [[nodiscard]] T* allocate(std::size_t count) {
    if (!is_large(count)) return static_cast<T*>(::operator new (count * sizeof(T), std::align_val_t{alignof(T)}));
    const std::size_t size = (count * sizeof(T) + page - 1) / page * page;
    void* const memory = ::operator new (size, std::align_val_t{page});
    ::madvise(memory, size, MADV_HUGEPAGE);
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, std::size_t count) {
    ::operator delete (memory, std::align_val_t{is_large(count) ? page : alignof(T)});
  }
  bool operator==(const LargeAllocator& /*other*/) const { return true; }

 private:
  static constexpr std::size_t page = std::size_t{2} << 20U;
  static bool is_large(std::size_t count) { return count * sizeof(T) >= page / 2; }
};

template <class T>
using LargeVector = std::vector<T, LargeAllocator<T>>;

}  // namespace tactor
