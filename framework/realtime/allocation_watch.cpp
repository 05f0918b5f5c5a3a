// Finds the counter in the program, where the program has one.
#include "framework/realtime/allocation_watch.hpp"

// Weak: a program may be linked without the counter, and then the address is null.
extern "C" __attribute__((weak)) std::int64_t tactor_thread_heap_calls() noexcept;

extern "C" __attribute__((weak)) void tactor_thread_count_heap_bytes(bool on) noexcept;
extern "C" __attribute__((weak)) std::int64_t tactor_thread_heap_bytes() noexcept;
extern "C" __attribute__((weak)) std::int64_t tactor_thread_heap_bytes_peak() noexcept;

namespace tactor {

void count_thread_heap_bytes(bool on) noexcept {
  if (tactor_thread_count_heap_bytes != nullptr) tactor_thread_count_heap_bytes(on);
}

std::int64_t thread_heap_bytes() noexcept {
  return tactor_thread_heap_bytes == nullptr ? 0 : tactor_thread_heap_bytes();
}

std::int64_t thread_heap_bytes_peak() noexcept {
  return tactor_thread_heap_bytes_peak == nullptr ? 0 : tactor_thread_heap_bytes_peak();
}

bool heap_calls_are_counted() noexcept {
  return tactor_thread_heap_calls != nullptr;
}

std::int64_t thread_heap_calls() noexcept {
  return tactor_thread_heap_calls == nullptr ? 0 : tactor_thread_heap_calls();
}

}  // namespace tactor
