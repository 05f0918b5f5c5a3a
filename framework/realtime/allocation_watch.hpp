// Counts the calls of the heap that each thread makes, so that "no allocation in the loop" is a metric and not a hope.
#pragma once

#include <cstdint>

namespace tactor {

/// True where the program counts: it was linked with `tactor_allocation_watch`, on glibc, without a sanitizer that has
/// a heap of its own.
[[nodiscard]] bool heap_calls_are_counted() noexcept;

/// The calls of malloc, calloc, realloc, free and their kin (operator new and delete among them) that the calling
/// thread has made since it began, in the program and in all libraries; 0 where they are not counted. Freeing counts
/// because it may wait for the heap's lock just as allocating may; free(nullptr) does not.
[[nodiscard]] std::int64_t thread_heap_calls() noexcept;

/// From here on the bytes of the heap that the calling thread takes and gives back are counted, from zero; or no
/// longer. Each call of the heap takes some nanoseconds more then. Without effect where calls are not counted.
void count_thread_heap_bytes(bool on) noexcept;

/// Bytes that the calling thread has taken less those it has given back, as the heap rounds them; negative where it
/// frees what was taken before, or on another thread.
[[nodiscard]] std::int64_t thread_heap_bytes() noexcept;

/// The most that thread_heap_bytes has been since this was last asked.
[[nodiscard]] std::int64_t thread_heap_bytes_peak() noexcept;

}  // namespace tactor
