// Readings of the clocks of the system.
#pragma once

#include <ctime>

#include "framework/core/time.hpp"

namespace tactor {

/// CPU time of this thread (CLOCK_THREAD_CPUTIME_ID) or of the process (CLOCK_PROCESS_CPUTIME_ID), or time that passed
/// (CLOCK_MONOTONIC).
inline Duration clock_time(clockid_t clock) noexcept {
  timespec t{};
  clock_gettime(clock, &t);
  return {t.tv_sec * 1'000'000'000 + t.tv_nsec};
}
/// The same in s.
inline double clock_seconds(clockid_t clock) noexcept {
  return clock_time(clock).seconds();
}

}  // namespace tactor
