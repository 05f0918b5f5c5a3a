// The loop itself: wakes at absolute deadlines, skips what it missed, calls the body, keeps the metrics.
#pragma once

#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <cstdint>

#include "framework/realtime/allocation_watch.hpp"
#include "framework/realtime/loop_statistics.hpp"
#include "framework/realtime/monotonic_clock.hpp"
#include "framework/realtime/pace.hpp"
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

/// What a loop counts around its body, on its own thread.
class TickMeter {
 public:
  /// The first `warm_up` ticks are left out of `heap_calls` and `page_faults`: code and thread-local storage are loaded
  /// the first time they are used.
  TickMeter(LoopStatistics& metrics, std::int64_t warm_up, double rate)
      : metrics_(metrics),
        warm_up_(warm_up),
        fault_check_(std::max<std::int64_t>(1, static_cast<std::int64_t>(rate / 10))) {}

  /// Calls the body for the tick; `missed` were skipped before it, and `now`, by `elapsed`, is when the loop woke for
  /// it. Sets `now` to the time after it.
  template <class Elapsed, class Body>
  void call(const Tick& tick, std::int64_t missed, Elapsed& elapsed, Time& now, Body& body) {
    metrics_.missed.add(missed);
    metrics_.begun.add(1);
    body(tick);
    const Time woke = now;
    now = elapsed.now();
    metrics_.body_time.record(now - woke);
    metrics_.body_ns.add((now - woke).ns);
    metrics_.ended.add(1);
    const std::int64_t ended = metrics_.ended.value();
    if (ended <= warm_up_) {
      heap_calls_before_ = thread_heap_calls();
      page_faults_before_ = thread_page_faults();
    } else {
      metrics_.heap_calls.set(thread_heap_calls() - heap_calls_before_);
      if (ended % fault_check_ == 0) count_page_faults();
    }
  }
  void count_page_faults() { metrics_.page_faults.set(thread_page_faults() - page_faults_before_); }

 private:
  LoopStatistics& metrics_;
  const std::int64_t warm_up_;
  const std::int64_t fault_check_;
  std::int64_t heap_calls_before_ = thread_heap_calls();
  std::int64_t page_faults_before_ = thread_page_faults();
};

/// So often at least a loop that sleeps looks whether it is to stop.
inline constexpr Duration longest_sleep{50'000'000};

/// Calls `body(const Tick&)` on the calling thread at `origin` + k / rate until `stop` is set, which it looks at before
/// each call and at least every 50 ms.
///
/// A loop that wakes so late that further deadlines have passed calls the body once, for the last of them; a body that
/// runs past deadlines waits for the next to come. Either way what was skipped is counted as missed, and no two calls
/// are made up for one wait. Allocates nothing, takes no lock and logs nothing. What the body throws passes through.
///
/// `clock` has `Instant now()` and `void sleep_until(Instant)`.
template <class Clock, class Body>
void run_ticks(Clock& clock, const TickSchedule& schedule, Instant origin, std::int64_t warm_up,
               const std::atomic<bool>& stop, LoopStatistics& metrics, Body&& body) {
  ElapsedTime elapsed(clock, origin, metrics.clock_steps);
  TickMeter meter(metrics, warm_up, schedule.rate());
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
    const std::int64_t missed = tick - last - 1;
    last = tick;
    meter.call(Tick{tick, schedule.deadline(tick)}, missed, elapsed, now, body);
  }
  meter.count_page_faults();
}

/// The same where something else sets the pace: calls the body at each beat, with the time of that beat as the tick's
/// deadline, and where none comes half a period late, at that time and then each period. Beats that come sooner than
/// three quarters of a period after a beat that made a tick are let pass. Periods without a tick are missed ones.
/// `pace` is a Pace.
template <class Clock, class Beats, class Body>
void run_ticks_by(Clock& clock, Beats& pace, const TickSchedule& schedule, Instant origin, std::int64_t warm_up,
                  const std::atomic<bool>& stop, LoopStatistics& metrics, Body&& body) {
  constexpr double soonest = 0.75, latest = 1.5;  // periods after a tick
  const Duration period = Duration::from_rate(schedule.rate());
  const auto periods = [&](double n) { return Duration::from_seconds(n / schedule.rate()); };
  ElapsedTime elapsed(clock, origin, metrics.clock_steps);
  TickMeter meter(metrics, warm_up, schedule.rate());
  const auto newest = [&] { return Time{} + (pace.newest() - elapsed.instant_of(Time{})); };
  Time now = elapsed.now();
  const auto sleep_to = [&](Time until) {
    while (now < until && !stop.load(std::memory_order_acquire)) {
      clock.sleep_until(elapsed.instant_of(std::min(until, now + longest_sleep)));
      now = elapsed.now();
    }
  };
  sleep_to(Time{});
  Time last = Time{} - period;
  std::int64_t number = -1;
  bool in_time = false;
  while (true) {
    const Time first = in_time ? last + periods(soonest) : last;
    const Time until = last + periods(in_time ? latest : 1);
    sleep_to(first);
    for (std::uint32_t seen = pace.beats(); newest() <= first && now < until; now = elapsed.now()) {
      if (stop.load(std::memory_order_acquire)) break;
      pace.wait(seen, elapsed.instant_of(std::min(until, now + longest_sleep)));
      seen = pace.beats();
    }
    if (stop.load(std::memory_order_acquire)) break;
    in_time = newest() > first;
    const Time due = std::max(Time{}, in_time ? newest() : std::max(until, now - period));
    metrics.wake_latency.record(now - due);
    const auto passed = static_cast<std::int64_t>((due - last).seconds() * schedule.rate() + 0.25);
    const std::int64_t missed = std::max<std::int64_t>(0, passed - 1);
    number += 1 + missed;
    last = due;
    meter.call(Tick{number, due}, missed, elapsed, now, body);
  }
  meter.count_page_faults();
}

}  // namespace tactor
