// What a loop with deadlines counts of itself while it runs, readable from any thread.
#pragma once

#include <atomic>
#include <cstdint>

#include "framework/realtime/latency_histogram.hpp"

namespace tactor {

/// A counter with one writer and any readers; plain loads and stores.
class LoopCounter {
 public:
  void add(std::int64_t n) noexcept { set(value() + n); }
  void set(std::int64_t n) noexcept { value_.store(n, std::memory_order_relaxed); }
  [[nodiscard]] std::int64_t value() const noexcept { return value_.load(std::memory_order_relaxed); }

 private:
  std::atomic<std::int64_t> value_{0};
};

/// Metrics of one loop. Written by the loop's thread alone, readable meanwhile; each is a moment old.
///
/// `begun` is the heartbeat. A body that hangs shows as `begun` = `ended` + 1 that stays; a thread that is not let run
/// shows as `begun` = `ended` that stays.
struct LoopStatistics {
  LoopCounter begun;   ///< ticks whose body was called
  LoopCounter ended;   ///< ticks whose body has come back
  LoopCounter missed;  ///< deadlines that were skipped: begun + missed = number of the last tick begun + 1
  /// Wake-up minus the deadline that was slept for, of each tick, the late ones that skipped others included.
  LatencyHistogram wake_latency;
  LatencyHistogram body_time;
  LoopCounter body_ns;  ///< the sum of all body times
  // Of the loop's thread, after its warm-up ticks.
  LoopCounter heap_calls;  ///< after every tick; stays 0 where heap_calls_are_counted() is false
  LoopCounter
      page_faults;  ///< minor and major; ten times a second and at the end, because reading them is a system call
  LoopCounter clock_steps;  ///< times the clock ran backwards, which a monotonic clock never does
};

}  // namespace tactor
