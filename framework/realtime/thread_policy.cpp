// The system calls behind a thread's settings, and the causes of their refusals.
#include "framework/realtime/thread_policy.hpp"

#include <pthread.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/resource.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "framework/realtime/make_thread.hpp"
#include "framework/realtime/memory_lock.hpp"

namespace tactor {

namespace {

bool set_policy(SchedulingPolicy policy, int priority) {
  sched_param parameter{};
  parameter.sched_priority = priority;
  const int number = policy == SchedulingPolicy::fifo          ? SCHED_FIFO
                     : policy == SchedulingPolicy::round_robin ? SCHED_RR
                                                               : SCHED_OTHER;
  return sched_setscheduler(0, number, &parameter) == 0;
}

/// Why the system refused a real-time policy with errno `error`, and what would help.
Refusal policy_refusal(const ThreadSettings& settings, std::uint64_t limit, int error) {
  Refusal refusal;
  refusal.what = std::string(settings.policy == SchedulingPolicy::fifo ? "SCHED_FIFO" : "SCHED_RR") + " at priority " +
                 std::to_string(settings.priority);
  const bool allowed =
      has_capability(Capability::sys_nice) || limit >= static_cast<std::uint64_t>(std::max(settings.priority, 0));
  if (!allowed) {
    refusal.why = "the limit rtprio is " + std::to_string(limit) + " and CAP_SYS_NICE is missing";
    refusal.remedy = privilege_remedy(Capability::sys_nice, "rtprio", "95");
    return refusal;
  }
  const std::optional<CgroupRealtime> group = cgroup_realtime();
  if (group && group->runtime_us == 0) {
    refusal.why = "the control group of this process has no real-time budget";
    refusal.remedy = "echo 950000 | sudo tee " + group->file.string();
    return refusal;
  }
  refusal.why = std::strerror(error);
  return refusal;
}

void apply_policy(const ThreadSettings& settings, ThreadGrant& grant) {
  if (settings.policy != SchedulingPolicy::other) {
    if (set_policy(settings.policy, settings.priority)) {
      grant.granted.policy = settings.policy;
      grant.granted.priority = settings.priority;
      return;
    }
    const int error = errno;
    const std::uint64_t limit = raised_limit(RLIMIT_RTPRIO);
    // The hard limit may allow what the soft one did not; and a lower priority still goes before all SCHED_OTHER.
    const int allowed = static_cast<int>(std::min<std::uint64_t>(limit, static_cast<std::uint64_t>(settings.priority)));
    if (allowed > 0 && set_policy(settings.policy, allowed)) {
      grant.granted.policy = settings.policy;
      grant.granted.priority = allowed;
      if (allowed == settings.priority) return;
    }
    grant.refused.push_back(policy_refusal(settings, limit, error));
    if (grant.granted.policy != SchedulingPolicy::other) return;
    setpriority(PRIO_PROCESS, 0, least_nice());
  }
  // Set and not left alone, because a thread inherits the policy of the one that made it.
  set_policy(SchedulingPolicy::other, 0);
  prctl(PR_SET_TIMERSLACK, 1UL, 0UL, 0UL, 0UL);
  grant.nice = getpriority(PRIO_PROCESS, 0);
}

void apply_core(const ThreadSettings& settings, ThreadGrant& grant) {
  if (!settings.cpu) return;
  const std::vector<int> allowed = usable_cores();
  if (std::find(allowed.begin(), allowed.end(), *settings.cpu) != allowed.end()) {
    cpu_set_t wanted;
    CPU_ZERO(&wanted);
    CPU_SET(*settings.cpu, &wanted);
    if (sched_setaffinity(0, sizeof wanted, &wanted) == 0) {
      grant.granted.cpu = settings.cpu;
      return;
    }
  }
  std::string cores;
  for (const int core : allowed) cores += (cores.empty() ? "" : ", ") + std::to_string(core);
  grant.refused.push_back({"core " + std::to_string(*settings.cpu), "this process may use the cores " + cores,
                           "name one of the cores " + cores + ", or none"});
}

}  // namespace

void give_way() {
  // Nobody is refused a lower priority.
  static_cast<void>(setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), 19));
}

std::vector<int> usable_cores() {
  cpu_set_t set;
  CPU_ZERO(&set);
  sched_getaffinity(0, sizeof set, &set);
  std::vector<int> cores;
  for (int core = 0; core < CPU_SETSIZE; ++core) {
    if (CPU_ISSET(core, &set)) cores.push_back(core);
  }
  return cores;
}

ThreadGrant apply_thread_settings(const ThreadSettings& settings, const std::string& name) {
  ThreadGrant grant;
  pthread_setname_np(pthread_self(), name.substr(0, 15).c_str());
  apply_core(settings, grant);
  apply_policy(settings, grant);
  return grant;
}

std::vector<Refusal> missing_privileges(std::span<const ThreadSettings> threads) {
  std::vector<Refusal> missing;
  const auto note = [&missing](const Refusal& refusal) {
    if (std::find(missing.begin(), missing.end(), refusal) == missing.end()) missing.push_back(refusal);
  };
  for (const ThreadSettings& settings : threads) {
    ThreadGrant grant;
    make_thread("probe", [&] { grant = apply_thread_settings(settings, "probe"); }).join();
    std::for_each(grant.refused.begin(), grant.refused.end(), note);
  }
  if (const std::optional<Refusal> refusal = memory_lock_refusal()) note(*refusal);
  return missing;
}

}  // namespace tactor
