// The time that a clock of the system shows, in seconds.
#pragma once

#include <ctime>

namespace tactor {

/// In s: CPU time of this thread (CLOCK_THREAD_CPUTIME_ID) or of the process (CLOCK_PROCESS_CPUTIME_ID), or time that
/// passed (CLOCK_MONOTONIC).
inline double clock_seconds(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

}  // namespace tactor
