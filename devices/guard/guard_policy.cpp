#include "devices/guard/guard_policy.hpp"

#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>

#include "framework/realtime/thread_policy.hpp"

namespace tactor {

namespace {

constexpr int fifo_priority = 90;  // above every loop of an engine, which are at 80 and below
constexpr Duration longest_period{1'000'000}, shortest_period{250'000};

/// struct sched_attr of the kernel, which the C library does not declare.
struct DeadlinePolicy {
  std::uint32_t size = 48;
  std::uint32_t policy = 6;  // SCHED_DEADLINE
  std::uint64_t flags = 1;   // children get SCHED_OTHER
  std::int32_t nice = 0;
  std::uint32_t priority = 0;
  std::uint64_t runtime = 0, deadline = 0, period = 0;  // ns
};
static_assert(sizeof(DeadlinePolicy) == 48);

}  // namespace

std::vector<std::string> take_guard_policy(Duration period, const std::string& name) {
  // The name, and what a thread may have inherited goes.
  apply_thread_settings({}, name);
  DeadlinePolicy wanted;
  wanted.period = static_cast<std::uint64_t>(std::clamp(period, shortest_period, longest_period).ns);
  // A shorter deadline would make the kernel put off a thread that an answer wakes after it.
  wanted.deadline = wanted.period;
  wanted.runtime = wanted.period * 3 / 10;
  if (syscall(SYS_sched_setattr, 0, &wanted, 0) == 0) return {};
  std::vector<std::string> lines{std::string("SCHED_DEADLINE refused: ") + std::strerror(errno) +
                                 "; `setcap cap_sys_nice+ep` on tactor-guard allows it"};
  ThreadSettings settings;
  settings.policy = SchedulingPolicy::fifo;
  settings.priority = fifo_priority;
  const ThreadGrant grant = apply_thread_settings(settings, name);
  for (const Refusal& refusal : grant.refused) lines.push_back(describe(refusal));
  lines.back() += grant.granted.policy == SchedulingPolicy::fifo
                      ? "; the guard runs under SCHED_FIFO"
                      : "; the guard runs as any program, and may be late on a busy machine";
  return lines;
}

}  // namespace tactor
