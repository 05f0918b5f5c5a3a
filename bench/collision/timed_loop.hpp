// The conditions under which the benchmark's loops are timed.
#pragma once

#include <chrono>
#include <optional>

#include "framework/realtime/thread_policy.hpp"

namespace tactor::bench {

/// Has the loops of this process timed on that core above everything that is no real-time program and below everything
/// that is, where the system permits it. Without this call, and with none, they run as any program. Returns what is
/// granted and what is refused.
ThreadGrant time_loops_on(std::optional<int> core);

/// While it lives the calling thread runs as `time_loops_on` says; before and after, while structures are built and
/// answers compared, it leaves the core to whoever else wants it.
class TimedLoop {
 public:
  TimedLoop();
  ~TimedLoop();
  TimedLoop(const TimedLoop&) = delete;
  TimedLoop& operator=(const TimedLoop&) = delete;

  /// The kernel takes a core away from real-time threads that leave nothing to others for most of a second; so rests
  /// come before, between the queries. Returns true after a rest, in which the caches have been someone else's.
  bool rest_if_due();

 private:
  std::chrono::steady_clock::time_point last_;
};

}  // namespace tactor::bench
