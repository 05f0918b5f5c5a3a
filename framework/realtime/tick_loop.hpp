// The loop itself: wakes at absolute deadlines, skips what it missed, calls the body, keeps the metrics.
#pragma once

#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <cstdint>

#include "framework/realtime/allocation_watch.hpp"
#include "framework/realtime/loop_statistics.hpp"
#include "framework/realtime/monotonic_clock.hpp"
#include "framework/realtime/tick_schedule.hpp"

namespace tactor {

/// What the body of a loop is told.
struct Tick {
  std::int64_t number = 0;  ///< k, from 0; consecutive but for the ticks that were missed
  Time deadline;            ///< when it was due, since the loop's origin
};

/// The page faults of the calling thread so far, minor and major.
inline std::int64_t thread_page_faults() noexcept {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  return usage.ru_minflt + usage.ru_majflt;
}

/// The time since an origin, by a clock that must not, but might, run backwards. Then the origin moves back with it:
/// the time stands still for that moment, and no deadline moves out of reach.
template <class Clock>
class ElapsedTime {
 public:
  ElapsedTime(Clock& clock, Instant origin, LoopCounter& steps)
      : clock_(clock), origin_(origin), last_(clock.now()), steps_(steps) {}

  [[nodiscard]] Time now() noexcept {
    const Instant reading = clock_.now();
    if (reading < last_) {
      origin_ = origin_ - (last_ - reading);
      steps_.add(1);
    }
    last_ = reading;
    return Time{} + (reading - origin_);
  }
  [[nodiscard]] Instant instant_of(Time t) const noexcept { return origin_ + (t - Time{}); }

 private:
  Clock& clock_;
  Instant origin_;
  Instant last_;
  LoopCounter& steps_;
};

/// Calls `body(const Tick&)` on the calling thread at `origin` + k / rate until `stop` is set, which it looks at before
/// each call and at least every 50 ms.
///
/// A loop that wakes so late that further deadlines have passed calls the body once, for the last of them; a body that
/// runs past deadlines waits for the next to come. Either way what was skipped is counted as missed, and no two calls
/// are made up for one wait. Allocates nothing, takes no lock and logs nothing. What the body throws passes through.
///
/// `clock` has `Instant now()` and `void sleep_until(Instant)`. The first `warm_up` ticks are left out of `heap_calls`
/// and `page_faults`: code and thread-local storage are loaded the first time they are used.
template <class Clock, class Body>
void run_ticks(Clock& clock, const TickSchedule& schedule, Instant origin, std::int64_t warm_up,
               const std::atomic<bool>& stop, LoopStatistics& metrics, Body&& body) {
  constexpr Duration longest_sleep{50'000'000};
  const auto fault_check = std::max<std::int64_t>(1, static_cast<std::int64_t>(schedule.rate() / 10));
  ElapsedTime elapsed(clock, origin, metrics.clock_steps);
  std::int64_t heap_calls_before = thread_heap_calls();
  std::int64_t page_faults_before = thread_page_faults();
  const auto count_page_faults = [&] { metrics.page_faults.set(thread_page_faults() - page_faults_before); };

  Time now = elapsed.now();
  std::int64_t last = -1;
  while (true) {
    // From the tick after the last on: the body may have taken no time that the clock can tell.
    const std::int64_t next = std::max(last + 1, schedule.first_due(now));
    const Time deadline = schedule.deadline(next);
    while (now < deadline && !stop.load(std::memory_order_acquire)) {
      clock.sleep_until(elapsed.instant_of(std::min(deadline, now + longest_sleep)));
      now = elapsed.now();
    }
    if (stop.load(std::memory_order_acquire)) break;
    metrics.wake_latency.record(now - deadline);

    const std::int64_t tick = schedule.last_due(now);
    metrics.missed.add(tick - last - 1);
    metrics.begun.add(1);
    last = tick;
    body(Tick{tick, schedule.deadline(tick)});
    const Time woke = now;
    now = elapsed.now();
    metrics.body_time.record(now - woke);
    metrics.body_ns.add((now - woke).ns);
    metrics.ended.add(1);

    const std::int64_t ended = metrics.ended.value();
    if (ended <= warm_up) {
      heap_calls_before = thread_heap_calls();
      page_faults_before = thread_page_faults();
    } else {
      metrics.heap_calls.set(thread_heap_calls() - heap_calls_before);
      if (ended % fault_check == 0) count_page_faults();
    }
  }
  count_page_faults();
}

}  // namespace tactor
