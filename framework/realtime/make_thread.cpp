#include "framework/realtime/make_thread.hpp"

#include <sys/resource.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>

namespace tactor {

namespace {

/// The value of a limit of this process; none where it is unlimited.
std::optional<std::uint64_t> limit_of(__rlimit_resource resource) {
  rlimit limit{};
  if (getrlimit(resource, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return std::nullopt;
  return limit.rlim_cur;
}

/// The most tasks that the control group (version 2) of this process, or the nearest one above it with a limit, may
/// have; none where there is no limit or it is not told.
std::optional<std::string> tasks_of_control_group() {
  std::ifstream groups("/proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {
    if (line.rfind("0::", 0) != 0) continue;
    for (std::filesystem::path group = line.substr(3);; group = group.parent_path()) {
      std::ifstream file("/sys/fs/cgroup" + group.string() + "/pids.max");
      std::string most;
      if (file >> most && most != "max") return most;
      if (group == group.parent_path()) break;
    }
  }
  return std::nullopt;
}

}  // namespace

std::string refused_start(const std::string& what, int error) {
  std::string text = "cannot start the " + what + ": " + std::strerror(error);
  std::string limits;
  if (const auto tasks = limit_of(RLIMIT_NPROC)) {
    limits += "\n  this user may have " + std::to_string(*tasks) +
              " threads and processes in all (ulimit -u); end some of them, or raise nproc in /etc/security/limits.d";
  }
  if (const auto tasks = tasks_of_control_group()) {
    limits += "\n  this control group may have " + *tasks +
              " threads (pids.max); raise it, in a container by --pids-limit, in a unit of systemd by TasksMax";
  }
  if (const auto bytes = limit_of(RLIMIT_AS)) {
    limits += "\n  this process may use " + std::to_string(*bytes >> 20U) +
              " MiB of address space (ulimit -v), of which each thread takes its stack";
  }
  if (!limits.empty()) limits = "; one of these limits stands in the way:" + limits;
  if (limits.empty()) limits = "\n  the system has no thread or no memory left (kernel.threads-max, free -m)";
  return text + limits;
}

}  // namespace tactor
