// The clock that device loops live by: readings of CLOCK_MONOTONIC and sleeping until one.
#pragma once

#include <cerrno>
#include <compare>
#include <cstdint>
#include <ctime>

#include "framework/core/check.hpp"
#include "framework/core/clock.hpp"
#include "framework/core/time.hpp"

namespace tactor {

/// A reading of a clock, in nanoseconds since an epoch of its own (the start of the machine); not a Time of the run.
struct Instant {
  std::int64_t ns = 0;

  constexpr auto operator<=>(const Instant&) const = default;
};

constexpr Instant operator+(Instant t, Duration d) {
  return {t.ns + d.ns};
}
constexpr Instant operator-(Instant t, Duration d) {
  return {t.ns - d.ns};
}
constexpr Duration operator-(Instant a, Instant b) {
  return {a.ns - b.ns};
}

/// CLOCK_MONOTONIC, which std::chrono::steady_clock reads too.
struct MonotonicClock {
  [[nodiscard]] static Instant now() noexcept { return {clock_time(CLOCK_MONOTONIC).ns}; }
  /// Returns at `t` or after it; at once where `t` has passed.
  static void sleep_until(Instant t) noexcept {
    // The system would set a timer all the same, which in a virtual machine takes some 25 us.
    if (t <= now()) return;
    const timespec deadline{t.ns / 1'000'000'000, t.ns % 1'000'000'000};
    int error = EINTR;
    while (error == EINTR) error = clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &deadline, nullptr);
    TACTOR_DEMAND(error == 0);
  }
};

}  // namespace tactor
