#include "bench/collision/timed_loop.hpp"

#include <thread>

namespace tactor::bench {

namespace {

std::optional<int> core_of_loops;

}  // namespace

TimedLoop::TimedLoop() {
  if (core_of_loops) apply_thread_settings({SchedulingPolicy::fifo, 1, core_of_loops}, "collision");
}

TimedLoop::~TimedLoop() {
  if (core_of_loops) apply_thread_settings({SchedulingPolicy::other, 0, core_of_loops}, "collision");
}

bool TimedLoop::rest_if_due() {
  if (std::chrono::steady_clock::now() - last_ < std::chrono::milliseconds(500)) return false;
  std::this_thread::sleep_for(std::chrono::milliseconds(60));
  last_ = std::chrono::steady_clock::now();
  return true;
}

ThreadGrant time_loops_on(std::optional<int> core) {
  core_of_loops = core;
  if (!core) return {};
  ThreadGrant grant = apply_thread_settings({SchedulingPolicy::fifo, 1, core}, "collision");
  apply_thread_settings({SchedulingPolicy::other, 0, core}, "collision");
  return grant;
}

}  // namespace tactor::bench
