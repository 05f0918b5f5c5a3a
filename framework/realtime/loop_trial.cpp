// The trials: an empty loop, beside computing threads or alone, and one that never sleeps.
#include "framework/realtime/loop_trial.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <memory>
#include <thread>
#include <vector>

#include "framework/realtime/make_thread.hpp"
#include "framework/realtime/memory_lock.hpp"
#include "framework/realtime/periodic_loop.hpp"

namespace tactor {

namespace {

/// One thread per core that computes until this ends.
class Load {
 public:
  explicit Load(unsigned threads) {
    try {
      for (unsigned i = 0; i < threads; ++i) {
        threads_.push_back(make_thread("load", [this] {
          while (!stop_.load(std::memory_order_relaxed)) {
          }
        }));
      }
    } catch (...) {
      end();
      throw;
    }
  }
  ~Load() { end(); }
  Load(const Load&) = delete;
  Load& operator=(const Load&) = delete;

 private:
  void end() {
    stop_.store(true);
    for (std::thread& thread : threads_) thread.join();
  }

  std::atomic<bool> stop_{false};
  std::vector<std::thread> threads_;
};

/// The real clock, moved ahead instead of waited for.
class HurriedClock {
 public:
  [[nodiscard]] Instant now() noexcept {
    last_ = MonotonicClock::now() + ahead_;
    return last_;
  }
  void sleep_until(Instant t) noexcept { ahead_ += t - last_; }

 private:
  Duration ahead_;
  Instant last_;
};

}  // namespace

LoopTrial try_loop(const ThreadSettings& settings, double rate, Duration length, bool beside_load) {
  const MemoryLock lock;
  const Load load(beside_load ? std::max(1U, std::thread::hardware_concurrency()) : 0U);
  PeriodicLoop loop({.name = "trial", .rate = rate, .thread = settings}, [](const Tick&) {});
  // A little later than now, so that making the thread costs no deadline.
  const Instant origin = MonotonicClock::now() + Duration{20'000'000};
  const ThreadGrant grant = loop.start(origin);
  LoopTrial trial{.granted = grant.granted, .nice = grant.nice, .beside_load = beside_load};
  MonotonicClock::sleep_until(origin + length);
  if (!loop.stop(Duration{5'000'000'000})) throw RunError("a loop that does nothing did not end within 5 s");
  const LoopStatistics& metrics = loop.metrics();
  trial.ticks = metrics.ended.value();
  trial.missed = metrics.missed.value();
  trial.page_faults = metrics.page_faults.value();
  trial.p50 = metrics.wake_latency.quantile(0.5);
  trial.p99 = metrics.wake_latency.quantile(0.99);
  trial.max = metrics.wake_latency.max();
  return trial;
}

Duration measure_bookkeeping() {
  constexpr std::int64_t ticks = 100'000;
  const auto metrics = std::make_unique<LoopStatistics>();
  HurriedClock clock;
  std::atomic<bool> stop{false};
  const Instant begin = MonotonicClock::now();
  run_ticks(clock, TickSchedule(1000), clock.now(), 0, stop, *metrics, [&](const Tick& tick) {
    if (tick.number >= ticks) stop.store(true, std::memory_order_relaxed);
  });
  return {(MonotonicClock::now() - begin).ns / ticks};
}

}  // namespace tactor
