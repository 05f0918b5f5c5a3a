#include "framework/realtime/pace.hpp"

#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <ctime>

namespace tactor {

namespace {

static_assert(sizeof(std::atomic<std::uint32_t>) == sizeof(std::uint32_t));

/// The system finds who waits sooner where it need not look beyond the process.
constexpr int futex_call(int call, bool between_processes) {
  return between_processes ? call : call | FUTEX_PRIVATE_FLAG;
}

}  // namespace

void Pace::beat() noexcept {
  newest_ns_.store(MonotonicClock::now().ns, std::memory_order_relaxed);
  beats_.fetch_add(1);
  // Either this sees the flag, or the waiting thread's call sees the new number.
  if (waits_.load()) syscall(SYS_futex, &beats_, futex_call(FUTEX_WAKE, between_processes_), 1, nullptr, nullptr, 0);
}

void Pace::wait(std::uint32_t seen, Instant end) noexcept {
  waits_.store(true);
  if (beats_.load() == seen) {
    const timespec until{end.ns / 1'000'000'000, end.ns % 1'000'000'000};
    syscall(SYS_futex, &beats_, futex_call(FUTEX_WAIT_BITSET, between_processes_), seen, &until, nullptr,
            FUTEX_BITSET_MATCH_ANY);
  }
  waits_.store(false, std::memory_order_relaxed);
}

}  // namespace tactor
