// A thread that sweeps through memory on one core, so that whatever else runs there finds cold caches.
#pragma once

#include <atomic>
#include <cstddef>
#include <thread>
#include <vector>

#include "framework/realtime/thread_policy.hpp"

namespace tactor::bench {

/// Works while it lives, under SCHED_OTHER on core `cpu`: reads and writes 8 MiB over and over, more than the caches
/// that a core of today has to itself.
class CacheLoad {
 public:
  explicit CacheLoad(int cpu) : thread_([this, cpu] { run(cpu); }) {}
  ~CacheLoad() {
    stop_ = true;
    thread_.join();
  }
  CacheLoad(const CacheLoad&) = delete;
  CacheLoad& operator=(const CacheLoad&) = delete;

 private:
  void run(int cpu) {
    apply_thread_settings({SchedulingPolicy::other, 0, cpu}, "load");
    constexpr std::size_t line = 64;
    std::vector<unsigned char> memory(std::size_t{8} << 20);
    while (!stop_.load(std::memory_order_relaxed)) {
      for (std::size_t i = 0; i < memory.size() && !stop_.load(std::memory_order_relaxed); i += line) ++memory[i];
    }
  }

  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace tactor::bench
