// The files and calls that the facts come from.
#include "framework/realtime/system_probe.hpp"

#include <sys/prctl.h>
#include <sys/utsname.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <set>
#include <sstream>
#include <utility>

#include "framework/realtime/memory_lock.hpp"
#include "framework/realtime/thread_policy.hpp"

namespace tactor {

namespace {

namespace fs = std::filesystem;

/// The first line of a file, or nothing where it cannot be read.
std::string first_line(const fs::path& file) {
  std::string line;
  std::ifstream stream(file);
  std::getline(stream, line);
  return line;
}

/// All of a file, unpacked where it is a gzip; empty where it cannot be read.
std::string whole(const fs::path& file) {
  std::string text;
  gzFile stream = gzopen(file.c_str(), "rb");
  if (stream == nullptr) return text;
  std::array<char, 4096> buffer{};
  for (int n = 0; (n = gzread(stream, buffer.data(), buffer.size())) > 0;) {
    text.append(buffer.data(), static_cast<std::size_t>(n));
  }
  gzclose(stream);
  return text;
}

std::optional<std::int64_t> number(const fs::path& file) {
  std::int64_t value = 0;
  if (std::ifstream(file) >> value) return value;
  return std::nullopt;
}

/// The files and folders of `folder` whose names begin with `prefix` and a digit.
std::vector<fs::path> numbered(const fs::path& folder, const std::string& prefix) {
  std::vector<fs::path> found;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    const bool fits = name.starts_with(prefix) && name.size() > prefix.size();
    if (fits && name.find_first_not_of("0123456789", prefix.size()) == std::string::npos) found.push_back(entry.path());
  }
  return found;
}

constexpr std::array<std::pair<const char*, Preemption>, 4> preemption_names{{{"none", Preemption::none},
                                                                              {"voluntary", Preemption::voluntary},
                                                                              {"lazy", Preemption::lazy},
                                                                              {"full", Preemption::full}}};

/// A switchable kernel says its mode in debugfs, to root; else the command line may have set it, else the build did.
Preemption dynamic_preemption(const fs::path& root, const std::string& release) {
  const std::string modes = first_line(root / "sys/kernel/debug/sched/preempt");
  const std::string options = " " + first_line(root / "proc/cmdline") + " ";
  for (const auto& [name, mode] : preemption_names) {
    if (modes.find("(" + std::string(name) + ")") != std::string::npos) return mode;
  }
  for (const auto& [name, mode] : preemption_names) {
    if (options.find(" preempt=" + std::string(name) + " ") != std::string::npos) return mode;
  }
  const std::string config =
      "\n" + whole(root / "boot" / ("config-" + release)) + "\n" + whole(root / "proc/config.gz");
  if (config.find("\nCONFIG_PREEMPT=y") != std::string::npos) return Preemption::full;
  if (config.find("\nCONFIG_PREEMPT_LAZY=y") != std::string::npos) return Preemption::lazy;
  if (config.find("\nCONFIG_PREEMPT_VOLUNTARY=y") != std::string::npos) return Preemption::voluntary;
  if (config.find("\nCONFIG_PREEMPT_NONE=y") != std::string::npos) return Preemption::none;
  return Preemption::unknown;
}

Preemption read_preemption(const fs::path& root, const std::string& release, const std::string& version) {
  if (number(root / "sys/kernel/realtime") == 1 || version.find("PREEMPT_RT") != std::string::npos)
    return Preemption::realtime;
  if (version.find("PREEMPT_DYNAMIC") != std::string::npos) return dynamic_preemption(root, release);
  if (version.find("PREEMPT") != std::string::npos) return Preemption::full;
  return Preemption::voluntary;
}

void read_processors(const fs::path& root, SystemFacts& facts) {
  const fs::path folder = root / "sys/devices/system/cpu";
  facts.isolated_cores = first_line(folder / "isolated");
  std::set<std::string> governors;
  for (const fs::path& core : numbered(folder, "cpu")) {
    if (const std::string governor = first_line(core / "cpufreq/scaling_governor"); !governor.empty())
      governors.insert(governor);
    for (const char* count : {"core_throttle_count", "package_throttle_count"}) {
      facts.thermal_throttlings += number(core / "thermal_throttle" / count).value_or(0);
    }
    for (const fs::path& state : numbered(core / "cpuidle", "state")) {
      if (number(state / "disable") == 1) continue;
      facts.idle_exit_latency_us = std::max(facts.idle_exit_latency_us, number(state / "latency").value_or(0));
    }
  }
  facts.governors.assign(governors.begin(), governors.end());
}

/// Steal is the eighth of the columns of /proc/stat; guest time, after it, is in the user time already.
double read_steal_share(const fs::path& root) {
  std::istringstream line(first_line(root / "proc/stat"));
  std::string name;
  line >> name;
  double total = 0;
  double steal = 0;
  double value = 0;
  for (int column = 1; column <= 8 && line >> value; ++column) {
    total += value;
    if (column == 8) steal = value;
  }
  return total > 0 ? steal / total : 0;
}

}  // namespace

SystemFacts probe_system(const fs::path& root) {
  SystemFacts facts;
  utsname name{};
  uname(&name);
  facts.kernel = std::string(name.release) + " " + name.version;

  const std::array wanted{ThreadSettings{SchedulingPolicy::fifo, 80, std::nullopt}};
  facts.memory_lock_refused = memory_lock_refusal();
  for (const Refusal& refusal : missing_privileges(wanted)) {
    if (refusal != facts.memory_lock_refused) facts.fifo_refused = refusal;
  }
  facts.least_nice = least_nice();
  facts.cores = static_cast<int>(usable_cores().size());
  facts.timer_slack_ns = prctl(PR_GET_TIMERSLACK, 0UL, 0UL, 0UL, 0UL);
  facts.cgroup = cgroup_realtime();

  read_processors(root, facts);
  facts.preemption = read_preemption(root, name.release, name.version);
  facts.rt_runtime_us = number(root / "proc/sys/kernel/sched_rt_runtime_us");
  facts.rt_period_us = number(root / "proc/sys/kernel/sched_rt_period_us").value_or(1'000'000);
  facts.clock_source = first_line(root / "sys/devices/system/clocksource/clocksource0/current_clocksource");
  facts.virtual_machine = (" " + whole(root / "proc/cpuinfo")).find(" hypervisor") != std::string::npos;
  facts.product = first_line(root / "sys/class/dmi/id/sys_vendor");
  if (const std::string product = first_line(root / "sys/class/dmi/id/product_name"); !product.empty())
    facts.product += (facts.product.empty() ? "" : " ") + product;
  facts.steal_share = read_steal_share(root);
  return facts;
}

}  // namespace tactor
