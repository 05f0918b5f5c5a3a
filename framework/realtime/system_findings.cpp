// The judgements, one function for each fact.
#include "framework/realtime/system_findings.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace tactor {

namespace {

Finding judge_fifo(const SystemFacts& facts) {
  if (!facts.fifo_refused) return {"fifo", "SCHED_FIFO", Grade::ok, "granted at priority 80", "", ""};
  return {"fifo",
          "SCHED_FIFO",
          Grade::degraded,
          "refused: " + facts.fifo_refused->why,
          "Every other program may run before the loop: on a busy machine it wakes milliseconds late.",
          facts.fifo_refused->remedy};
}

Finding judge_memory_lock(const SystemFacts& facts) {
  if (!facts.memory_lock_refused) return {"memory_lock", "memory lock", Grade::ok, "allowed, without limit", "", ""};
  return {"memory_lock",
          "memory lock",
          Grade::degraded,
          "refused: " + facts.memory_lock_refused->why,
          "When memory runs short, the kernel takes pages back, and the loop waits for the disk.",
          facts.memory_lock_refused->remedy};
}

Finding judge_nice(const SystemFacts& facts) {
  const std::string found = "down to " + std::to_string(facts.least_nice);
  if (facts.least_nice < 0) return {"nice", "nice", Grade::ok, found, "", ""};
  // What SCHED_FIFO gives is more than what nice could.
  if (!facts.fifo_refused) return {"nice", "nice", Grade::ok, found + ", not needed beside SCHED_FIFO", "", ""};
  return {"nice",
          "nice",
          Grade::degraded,
          found,
          "Without SCHED_FIFO the loop has no priority over other programs.",
          privilege_remedy(Capability::sys_nice, "nice", "-20")};
}

Finding judge_cores(const SystemFacts& facts) {
  Finding finding{"cores", "cores", Grade::ok, std::to_string(facts.cores) + " usable", "", ""};
  finding.found += facts.isolated_cores.empty() ? ", none isolated" : ", isolated: " + facts.isolated_cores;
  if (facts.cores < 2) {
    finding.grade = Grade::degraded;
    finding.cost = "The loop interrupts the physics on the only core, and waits for the kernel's work there.";
    finding.remedy = "give the machine, the container (--cpus) or the process (taskset) two cores";
  }
  return finding;
}

Finding judge_preemption(const SystemFacts& facts) {
  Finding finding{"preemption", "preemption", Grade::ok, "", "", ""};
  const std::string into_full =
      "echo full | sudo tee /sys/kernel/debug/sched/preempt # for good: boot with preempt=full";
  switch (facts.preemption) {
    case Preemption::realtime:
      finding.found = "PREEMPT_RT";
      return finding;
    case Preemption::full:
      finding.found = "full";
      return finding;
    case Preemption::lazy:
      finding.found = "lazy, full for real-time threads";
      return finding;
    case Preemption::voluntary:
      finding.found = "voluntary";
      break;
    case Preemption::none:
      finding.found = "none";
      break;
    case Preemption::unknown:
      finding.found = "switchable, but this user may not see the mode";
      finding.grade = Grade::degraded;
      finding.cost = "Unknown. With mode none, a long system call of another program delays the loop.";
      finding.remedy = "boot with preempt=full";
      return finding;
  }
  finding.grade = Grade::degraded;
  finding.cost = "A long system call of another program delays the loop until it returns: rare delays of milliseconds.";
  const bool switchable = facts.kernel.find("PREEMPT_DYNAMIC") != std::string::npos;
  finding.remedy = switchable ? into_full : "sudo apt install linux-image-rt-amd64 # then start that kernel";
  return finding;
}

Finding judge_governor(const SystemFacts& facts) {
  Finding finding{"governor", "CPU governor", Grade::ok, "none: the kernel changes no frequency here", "", ""};
  if (facts.governors.empty()) return finding;
  finding.found.clear();
  for (const std::string& governor : facts.governors) finding.found += (finding.found.empty() ? "" : ", ") + governor;
  if (facts.governors == std::vector<std::string>{"performance"}) return finding;
  finding.grade = Grade::degraded;
  finding.cost = "A core that mostly waits is clocked down, and each tick runs at the low frequency.";
  finding.remedy = "sudo cpupower frequency-set -g performance";
  return finding;
}

Finding judge_throttling(const SystemFacts& facts) {
  if (facts.thermal_throttlings == 0) return {"throttling", "heat", Grade::ok, "never throttled, or not shown", "", ""};
  return {"throttling",
          "heat",
          Grade::degraded,
          "throttled " + std::to_string(facts.thermal_throttlings) + " times since the start",
          "A hot core is slowed down, and with it the physics and the loop.",
          "sudo cpupower frequency-set -u 2GHz # or cool the machine"};
}

Finding judge_idle_states(const SystemFacts& facts) {
  constexpr std::int64_t tolerable_us = 50;
  const std::string latency = std::to_string(facts.idle_exit_latency_us) + " us";
  if (facts.idle_exit_latency_us == 0) return {"idle_states", "idle states", Grade::ok, "none shown", "", ""};
  if (facts.idle_exit_latency_us <= tolerable_us)
    return {"idle_states", "idle states", Grade::ok, "left within " + latency, "", ""};
  return {"idle_states",
          "idle states",
          Grade::degraded,
          "the deepest takes " + latency + " to leave",
          "On an idle core, the loop wakes up to that much later.",
          "sudo cpupower idle-set -D " + std::to_string(tolerable_us)};
}

Finding judge_rt_throttling(const SystemFacts& facts) {
  Finding finding{"rt_throttling", "RT throttling", Grade::ok, "not shown", "", ""};
  if (!facts.rt_runtime_us) return finding;
  if (*facts.rt_runtime_us < 0) {
    finding.found = "off: a real-time thread that spins stops the machine";
    return finding;
  }
  const double share = 100.0 * static_cast<double>(*facts.rt_runtime_us) / static_cast<double>(facts.rt_period_us);
  finding.found = "real-time threads get " + std::to_string(std::lround(share)) + " % of " +
                  std::to_string(facts.rt_period_us / 1000) + " ms";
  if (share >= 90) return finding;
  finding.grade = share > 0 ? Grade::degraded : Grade::bad;
  finding.cost = "Real-time threads that use more than that are stopped for the rest of each period.";
  finding.remedy = "sudo sysctl -w kernel.sched_rt_runtime_us=" + std::to_string(facts.rt_period_us * 95 / 100);
  return finding;
}

Finding judge_cgroup(const SystemFacts& facts) {
  Finding finding{"cgroup", "RT budget", Grade::ok, "the control group sets none", "", ""};
  if (!facts.cgroup) return finding;
  finding.found = "the control group has " + std::to_string(facts.cgroup->runtime_us / 1000) + " ms of each period";
  if (facts.cgroup->runtime_us != 0) return finding;
  finding.grade = Grade::degraded;
  finding.found = "the control group has none";
  finding.cost = "No thread in the group may be SCHED_FIFO, not even root's.";
  finding.remedy = "echo 950000 | sudo tee " + facts.cgroup->file.string();
  return finding;
}

Finding judge_timer_slack(const SystemFacts& facts) {
  return {"timer_slack",
          "timer slack",
          Grade::ok,
          std::to_string(facts.timer_slack_ns) + " ns by default; Tactor's loops set 1 ns for themselves",
          "",
          ""};
}

Finding judge_clock_source(const SystemFacts& facts) {
  constexpr std::array<std::string_view, 5> fast{"tsc", "kvm-clock", "hyperv_clocksource_tsc_page", "arch_sys_counter",
                                                 "xen"};
  Finding finding{"clock_source", "clock source", Grade::ok, facts.clock_source, "", ""};
  if (facts.clock_source.empty()) finding.found = "not shown";
  if (facts.clock_source.empty() || std::find(fast.begin(), fast.end(), facts.clock_source) != fast.end())
    return finding;
  finding.grade = Grade::degraded;
  finding.cost = "Each reading of the clock is a system call of about a microsecond; a tick reads it twice.";
  finding.remedy = "boot with tsc=reliable, if the processor's counter is constant (grep constant_tsc /proc/cpuinfo)";
  return finding;
}

Finding judge_machine(const SystemFacts& facts) {
  const std::string product = facts.product.empty() ? "" : " (" + facts.product + ")";
  if (!facts.virtual_machine) return {"machine", "machine", Grade::ok, "bare metal" + product, "", ""};
  const std::string stolen = std::to_string(std::lround(1e6 * facts.steal_share));
  return {
      "machine",
      "machine",
      Grade::degraded,
      "virtual" + product + "; its host kept " + stolen + " millionths of the time for itself",
      "The host may take a core away at any moment: rare delays of milliseconds that nothing in the guest can prevent.",
      "run on bare metal; or pin each virtual core to its own real core on the host"};
}

}  // namespace

std::string_view to_string(Grade grade) {
  constexpr std::array<std::string_view, 3> names{"ok", "degraded", "bad"};
  return names[static_cast<std::size_t>(grade)];
}

std::vector<Finding> judge(const SystemFacts& facts) {
  return {judge_fifo(facts),          judge_memory_lock(facts), judge_nice(facts),        judge_cores(facts),
          judge_preemption(facts),    judge_governor(facts),    judge_throttling(facts),  judge_idle_states(facts),
          judge_rt_throttling(facts), judge_cgroup(facts),      judge_timer_slack(facts), judge_clock_source(facts),
          judge_machine(facts)};
}

Grade worst(const std::vector<Finding>& findings) {
  Grade grade = Grade::ok;
  for (const Finding& finding : findings) grade = std::max(grade, finding.grade);
  return grade;
}

}  // namespace tactor
