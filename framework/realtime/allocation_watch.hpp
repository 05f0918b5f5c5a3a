// Counts the calls of the heap that each thread makes, so that "no allocation in the loop" is a figure and not a hope.
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

}  // namespace tactor
