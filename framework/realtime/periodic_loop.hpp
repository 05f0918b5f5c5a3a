// A thread that calls a body at absolute deadlines: what the force of a device is computed in.
#pragma once

#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <string>

#include "framework/core/scheduling.hpp"
#include "framework/realtime/loop_statistics.hpp"
#include "framework/realtime/monotonic_clock.hpp"
#include "framework/realtime/thread_policy.hpp"
#include "framework/realtime/tick_loop.hpp"

namespace tactor {

/// The choices of a loop.
struct LoopSettings {
  std::string name;                                  ///< of the thread, as `top -H` shows it; cut to 15 characters
  double rate = 1000;                                ///< Hz, above 0 and at most TickSchedule::max_rate
  ThreadSettings thread;                             ///< what the thread asks for
  std::size_t stack_size = std::size_t{256} * 1024;  ///< bytes, thread-local storage included; all touched at the start
  std::int64_t warm_up_ticks = 10;                   ///< ticks whose heap calls and page faults are not counted
  Pace* pace = nullptr;                              ///< in place of deadlines; outlives the loop
};

/// Calls a body at `origin` + k / rate on a thread of its own, or at the beats of a pace: see run_ticks and
/// run_ticks_by for what happens when it is late.
///
/// The thread holds no lock and allocates nothing between two ticks. The body must not either, nor may it throw: what
/// it throws ends the loop and is kept. One loop starts once; all members but `metrics` and the flags belong to one
/// thread.
class PeriodicLoop {
 public:
  using Body = std::function<void(const Tick&)>;

  PeriodicLoop(const LoopSettings& settings, Body body);
  /// Stops with a patience of one second. Where the body hangs for longer the thread is left behind with
  /// its body; whatever the body refers to must then outlive it, so end the process.
  ~PeriodicLoop();
  PeriodicLoop(const PeriodicLoop&) = delete;
  PeriodicLoop& operator=(const PeriodicLoop&) = delete;

  /// Makes the thread and returns, before its first tick or after, what it was granted. Ticks that were due before the
  /// thread was ready count as missed. Throws RunError where the system gives no thread.
  ThreadGrant start(Instant origin);

  /// Ends the loop after the current call of the body and joins the thread. False where the body has not come back
  /// within `patience`; then it may be called again. True where nothing runs.
  [[nodiscard]] bool stop(Duration patience);

  /// True from `start` until the loop has ended, by `stop` or by an exception.
  [[nodiscard]] bool running() const noexcept;
  /// What the body threw; null where it has not. Any thread may ask.
  [[nodiscard]] std::exception_ptr failure() const noexcept;
  [[nodiscard]] const LoopStatistics& metrics() const noexcept;

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;  ///< with the thread, which may have to be left behind
};

}  // namespace tactor
