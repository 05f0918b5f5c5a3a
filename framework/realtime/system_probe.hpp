// Reads what a machine, its kernel and this process offer to a real-time loop.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "framework/realtime/privilege.hpp"

namespace tactor {

/// How the kernel lets a waiting thread interrupt its own code, from the least to the most.
enum class Preemption : std::uint8_t {
  unknown,    ///< the kernel can switch (PREEMPT_DYNAMIC) and does not let this user read to what
  none,       ///< at system-call borders alone
  voluntary,  ///< at chosen points too
  lazy,       ///< nearly everywhere for real-time threads, at borders for others
  full,       ///< nearly everywhere
  realtime,   ///< PREEMPT_RT: interrupts run as threads, locks can be preempted
};

/// The facts, ungraded. What a machine does not have or does not show is absent or empty.
struct SystemFacts {
  std::string kernel;  ///< release and version, as uname tells them
  std::optional<Refusal> fifo_refused;
  std::optional<Refusal> memory_lock_refused;
  int least_nice = 0;  ///< that this process may take, -20 to 19
  int cores = 0;       ///< that this process may use
  std::string isolated_cores;
  Preemption preemption = Preemption::unknown;
  std::vector<std::string> governors;         ///< of all cores, each told once
  std::int64_t thermal_throttlings = 0;       ///< since the machine started
  std::int64_t idle_exit_latency_us = 0;      ///< of the deepest idle state that is not disabled
  std::optional<std::int64_t> rt_runtime_us;  ///< of each rt_period_us that real-time threads may use; -1: all
  std::int64_t rt_period_us = 0;
  std::optional<CgroupRealtime> cgroup;
  std::int64_t timer_slack_ns = 0;  ///< of a thread that asks for nothing
  std::string clock_source;
  bool virtual_machine = false;
  std::string product;     ///< who made the machine, real or virtual
  double steal_share = 0;  ///< of all time since the machine started, what the host kept for itself
};

/// Reads the facts. `root` stands before /proc, /sys and /boot; what belongs to the process itself (privileges, timer
/// slack, cores) is asked of the system whatever it says. Tries SCHED_FIFO at priority 80 on a thread that ends at
/// once.
SystemFacts probe_system(const std::filesystem::path& root = "/");

}  // namespace tactor
