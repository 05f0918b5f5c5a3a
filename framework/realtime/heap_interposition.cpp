// Stands in front of glibc's heap and counts each thread's calls; the heap itself stays glibc's.
#include <malloc.h>

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

// The sanitizers bring a heap of their own and are not to be stood in front of.
#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

namespace {

// Initial-exec, because storage that is made at first use would be allocated by the very call that counts.
__attribute__((tls_model("initial-exec"))) thread_local std::int64_t heap_calls = 0;
// Bytes are counted where somebody asked for it: looking up the size of a block takes some nanoseconds.
__attribute__((tls_model("initial-exec"))) thread_local bool counts_bytes = false;
__attribute__((tls_model("initial-exec"))) thread_local std::int64_t heap_bytes = 0;
__attribute__((tls_model("initial-exec"))) thread_local std::int64_t heap_bytes_peak = 0;

void* added(void* block) {
  if (!counts_bytes || block == nullptr) return block;
  heap_bytes += static_cast<std::int64_t>(malloc_usable_size(block));
  if (heap_bytes > heap_bytes_peak) heap_bytes_peak = heap_bytes;
  return block;
}

void leaving(void* block) {
  if (counts_bytes && block != nullptr) heap_bytes -= static_cast<std::int64_t>(malloc_usable_size(block));
}

}  // namespace

extern "C" {

// glibc's names for its own functions, for those who stand in front of them.
// NOLINTBEGIN(bugprone-reserved-identifier)
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* block, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);
void* __libc_valloc(std::size_t size);
void* __libc_pvalloc(std::size_t size);
void __libc_free(void* block);
// NOLINTEND(bugprone-reserved-identifier)

// Read by thread_heap_calls, by name.
__attribute__((visibility("default"))) std::int64_t tactor_thread_heap_calls() noexcept {
  return heap_calls;
}

__attribute__((visibility("default"))) void tactor_thread_count_heap_bytes(bool on) noexcept {
  counts_bytes = on;
  heap_bytes = heap_bytes_peak = 0;
}
__attribute__((visibility("default"))) std::int64_t tactor_thread_heap_bytes() noexcept {
  return heap_bytes;
}
// The most since it was last asked.
__attribute__((visibility("default"))) std::int64_t tactor_thread_heap_bytes_peak() noexcept {
  const std::int64_t peak = heap_bytes_peak;
  heap_bytes_peak = heap_bytes;
  return peak;
}

void* malloc(std::size_t size) {
  ++heap_calls;
  return added(__libc_malloc(size));
}

void* calloc(std::size_t count, std::size_t size) {
  ++heap_calls;
  return added(__libc_calloc(count, size));
}

void* realloc(void* block, std::size_t size) {
  ++heap_calls;
  leaving(block);
  return added(__libc_realloc(block, size));
}

void* reallocarray(void* block, std::size_t count, std::size_t size) {
  std::size_t bytes = 0;
  if (__builtin_mul_overflow(count, size, &bytes)) {
    errno = ENOMEM;
    return nullptr;
  }
  ++heap_calls;
  leaving(block);
  return added(__libc_realloc(block, bytes));
}

void* memalign(std::size_t alignment, std::size_t size) {
  ++heap_calls;
  return added(__libc_memalign(alignment, size));
}

void* aligned_alloc(std::size_t alignment, std::size_t size) {
  ++heap_calls;
  return added(__libc_memalign(alignment, size));
}

int posix_memalign(void** block, std::size_t alignment, std::size_t size) {
  const bool power_of_two = alignment != 0 && (alignment & (alignment - 1)) == 0;
  if (!power_of_two || alignment % sizeof(void*) != 0) return EINVAL;
  ++heap_calls;
  // The address and not errno tells of failure, and errno is to stay as it was.
  const int saved = errno;
  void* allocated = __libc_memalign(alignment, size);
  errno = saved;
  if (allocated == nullptr) return ENOMEM;
  *block = added(allocated);
  return 0;
}

void* valloc(std::size_t size) {
  ++heap_calls;
  return added(__libc_valloc(size));
}

void* pvalloc(std::size_t size) {
  ++heap_calls;
  return added(__libc_pvalloc(size));
}

void free(void* block) {
  if (block == nullptr) return;
  ++heap_calls;
  leaving(block);
  __libc_free(block);
}

}  // extern "C"

#endif
