// Reads capabilities, limits and control groups.
#include "framework/realtime/privilege.hpp"

#include <linux/capability.h>
#include <pwd.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <fstream>

namespace tactor {

namespace {

/// The name of the user, or its number where it has none.
std::string user_name() {
  std::array<char, 4096> buffer{};
  passwd entry{};
  passwd* found = nullptr;
  if (getpwuid_r(getuid(), &entry, buffer.data(), buffer.size(), &found) == 0 && found != nullptr) return entry.pw_name;
  return std::to_string(getuid());
}

}  // namespace

std::string describe(const Refusal& refusal) {
  std::string text = refusal.what + " refused: " + refusal.why;
  if (!refusal.remedy.empty()) text += "; to fix it: " + refusal.remedy;
  return text;
}

bool has_capability(Capability capability) {
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  std::array<__user_cap_data_struct, _LINUX_CAPABILITY_U32S_3> data{};
  if (syscall(SYS_capget, &header, data.data()) != 0) return false;
  const unsigned number = capability == Capability::sys_nice ? CAP_SYS_NICE : CAP_IPC_LOCK;
  return (data[CAP_TO_INDEX(number)].effective & CAP_TO_MASK(number)) != 0;
}

std::uint64_t raised_limit(int resource) {
  rlimit limit{};
  if (getrlimit(static_cast<__rlimit_resource>(resource), &limit) != 0) return 0;
  if (limit.rlim_cur < limit.rlim_max) {
    const rlimit raised{limit.rlim_max, limit.rlim_max};
    if (setrlimit(static_cast<__rlimit_resource>(resource), &raised) == 0) limit = raised;
  }
  return limit.rlim_cur;
}

int least_nice() {
  if (has_capability(Capability::sys_nice)) return -20;
  const auto limit = static_cast<int>(std::min<std::uint64_t>(raised_limit(RLIMIT_NICE), 40));
  return std::min(getpriority(PRIO_PROCESS, 0), 20 - limit);
}

std::string privilege_remedy(Capability capability, std::string_view item, std::string_view value) {
  if (geteuid() == 0) {
    // The limits of a container are numbers: -1 for no limit, and 20 less the niceness.
    const std::string limit = std::string(item) + (item == "memlock" ? "=-1"
                                                   : item == "nice"  ? "=40"
                                                                     : "=" + std::string(value));
    const std::string name = capability == Capability::sys_nice ? "SYS_NICE" : "IPC_LOCK";
    return "start the container with --cap-add " + name + " --ulimit " + limit;
  }
  return "echo '" + user_name() + " - " + std::string(item) + " " + std::string(value) +
         "' | sudo tee -a /etc/security/limits.d/tactor.conf # then log in again";
}

std::optional<CgroupRealtime> cgroup_realtime() {
  std::ifstream groups("/proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {
    // Such as `4:cpu,cpuacct:/user.slice`; the list is empty for version 2, which has no such budget.
    const std::size_t first = line.find(':');
    const std::size_t second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",";
    if (controllers.find(",cpu,") == std::string::npos) continue;
    // Inside a container the group that is the root there is mounted at the root.
    for (const std::string& group : {line.substr(second + 1), std::string("/")}) {
      CgroupRealtime found{std::filesystem::path("/sys/fs/cgroup/cpu" + group) / "cpu.rt_runtime_us"};
      if (std::ifstream(found.file) >> found.runtime_us) return found;
    }
  }
  return std::nullopt;
}

}  // namespace tactor
