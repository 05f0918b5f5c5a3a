#include "devices/hardware/inherited_policy.hpp"

#include <sched.h>
#include <sys/resource.h>

#include <algorithm>
#include <utility>

#include "framework/realtime/thread_policy.hpp"

namespace tactor {

void InheritedPolicy::tell() noexcept {
  told_ = true;
  sched_param parameter{};
  sched_getparam(0, &parameter);
  policy_ = sched_getscheduler(0) & ~SCHED_RESET_ON_FORK;
  priority_ = parameter.sched_priority;
  nice_ = getpriority(PRIO_PROCESS, 0);
  known_.store(true, std::memory_order_release);
}

std::vector<Refusal> InheritedPolicy::take(const std::string& thread_name) {
  if (taken_ || !known_.load(std::memory_order_acquire)) return {};
  taken_ = true;
  ThreadSettings settings;
  if (policy_ == SCHED_FIFO || policy_ == SCHED_RR) {
    settings.policy = policy_ == SCHED_FIFO ? SchedulingPolicy::fifo : SchedulingPolicy::round_robin;
    settings.priority = std::max(1, priority_ - 1);
  }
  ThreadGrant grant = apply_thread_settings(settings, thread_name);
  if (settings.policy == SchedulingPolicy::other) setpriority(PRIO_PROCESS, 0, nice_);
  return std::move(grant.refused);
}

}  // namespace tactor
