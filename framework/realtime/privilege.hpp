// What the operating system may refuse to a real-time program, why, and the line that repairs it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace tactor {

/// Something that was asked of the operating system and not given.
struct Refusal {
  std::string what;    ///< what was asked: `SCHED_FIFO at priority 80`
  std::string why;     ///< what stands in the way
  std::string remedy;  ///< a command to copy, `#` before what it does not do; empty where nothing is known to help

  bool operator==(const Refusal&) const = default;
};

/// One line: what, why and the remedy.
std::string describe(const Refusal& refusal);

/// A privilege of the kernel that a process may hold.
enum class Capability : std::uint8_t {
  sys_nice,  ///< CAP_SYS_NICE: any scheduling policy and priority
  ipc_lock,  ///< CAP_IPC_LOCK: any amount of locked memory
};

/// Whether the calling thread holds it now.
bool has_capability(Capability capability);

/// A limit of the process (RLIMIT_RTPRIO, RLIMIT_MEMLOCK), its soft value first raised to the hard one, which needs no
/// privilege. RLIM_INFINITY where there is none.
std::uint64_t raised_limit(int resource);

/// The lowest niceness that the calling thread may take, -20 to 19; its own where it may take none lower.
int least_nice();

/// The remedy for a missing capability: the limits.d line `item value` for this user; for root, who lacks it only
/// inside a container, the option that starts the container with it.
std::string privilege_remedy(Capability capability, std::string_view item, std::string_view value);

/// The real-time budget of the cpu cgroup that this process is in, as cgroups of version 1 have it.
struct CgroupRealtime {
  std::filesystem::path file;   ///< cpu.rt_runtime_us
  std::int64_t runtime_us = 0;  ///< of each period; 0: no thread in it may be SCHED_FIFO, not even root's
};

/// Nothing where the kernel has no such budget or it cannot be read.
std::optional<CgroupRealtime> cgroup_realtime();

}  // namespace tactor
