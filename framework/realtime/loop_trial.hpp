// Tries a loop on this very machine and tells how late it woke and what it costs.
#pragma once

#include <cstdint>

#include "framework/realtime/thread_policy.hpp"

namespace tactor {

/// What a loop with an empty body did.
struct LoopTrial {
  ThreadSettings granted;
  int nice = 0;              ///< as in ThreadGrant
  bool beside_load = false;  ///< each core had a thread that computes without end, under SCHED_OTHER
  std::int64_t ticks = 0;
  std::int64_t missed = 0;
  std::int64_t page_faults = 0;
  Duration p50;  ///< of the wake-up latency
  Duration p99;
  Duration max;
};

/// Runs a loop at `rate` Hz for `length`, with the memory locked where that is allowed.
LoopTrial try_loop(const ThreadSettings& settings, double rate, Duration length, bool beside_load);

/// What the loop itself costs per tick: reading the clock twice and keeping the metrics, without sleeping. The
/// mean of 100,000 ticks.
Duration measure_bookkeeping();

}  // namespace tactor
