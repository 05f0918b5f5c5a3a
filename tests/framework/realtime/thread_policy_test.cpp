// What a thread asks for it gets where it may, and where it may not it is told why and what would help.
#include "framework/realtime/thread_policy.hpp"

#include <linux/capability.h>
#include <pthread.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <boost/test/unit_test.hpp>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>
#include <string>
#include <thread>

#include "framework/realtime/memory_lock.hpp"
#include "framework/realtime/periodic_loop.hpp"

BOOST_AUTO_TEST_SUITE(thread_policy_test)

using namespace tactor;
namespace utf = boost::unit_test;

namespace {

constexpr ThreadSettings fifo_40{SchedulingPolicy::fifo, 40, std::nullopt};

void on_a_thread(const std::function<void()>& work) {
  std::thread(work).join();
}

boost::test_tools::assertion_result may_fifo(utf::test_unit_id) {
  boost::test_tools::assertion_result result(true);
  on_a_thread([&result] {
    const ThreadGrant grant = apply_thread_settings(fifo_40, "probe");
    if (grant.granted != fifo_40) {
      result = boost::test_tools::assertion_result(false);
      result.message() << describe(grant.refused.front());
    }
  });
  return result;
}

/// A limit for real-time priorities is a privilege to give oneself, too.
boost::test_tools::assertion_result may_fifo_and_limit_it(utf::test_unit_id unit) {
  rlimit limit{};
  getrlimit(RLIMIT_RTPRIO, &limit);
  if (limit.rlim_max >= 95) return may_fifo(unit);
  const rlimit raised{95, 95};
  if (setrlimit(RLIMIT_RTPRIO, &raised) == 0) {
    setrlimit(RLIMIT_RTPRIO, &limit);
    return may_fifo(unit);
  }
  boost::test_tools::assertion_result result(false);
  result.message() << "this user may not raise RLIMIT_RTPRIO";
  return result;
}

/// A control group without a real-time budget, as each new one is; empty where none can be made.
class GroupWithoutBudget {
 public:
  GroupWithoutBudget() {
    const std::optional<CgroupRealtime> own = cgroup_realtime();
    if (!own) return;
    path_ = own->file.parent_path() / ("tactor-test-" + std::to_string(getpid()));
    std::error_code error;
    if (!std::filesystem::create_directory(path_, error)) path_.clear();
  }
  ~GroupWithoutBudget() {
    std::error_code error;
    if (made()) std::filesystem::remove(path_, error);
  }
  GroupWithoutBudget(const GroupWithoutBudget&) = delete;
  GroupWithoutBudget& operator=(const GroupWithoutBudget&) = delete;

  [[nodiscard]] bool made() const { return !path_.empty(); }
  /// Moves the calling process into it.
  [[nodiscard]] bool join() const {
    std::ofstream processes(path_ / "cgroup.procs");
    processes << getpid();
    return static_cast<bool>(processes.flush());
  }

 private:
  std::filesystem::path path_;
};

boost::test_tools::assertion_result may_make_groups(utf::test_unit_id) {
  const GroupWithoutBudget group;
  boost::test_tools::assertion_result result(group.made() && has_capability(Capability::sys_nice));
  result.message() << "this needs root and control groups of version 1 with a real-time budget";
  return result;
}

/// Runs `work` in a child process and returns the text it makes.
std::string in_a_child(const std::function<std::string()>& work) {
  std::array<int, 2> ends{};
  BOOST_REQUIRE(pipe(ends.data()) == 0);
  const pid_t child = fork();
  BOOST_REQUIRE(child >= 0);
  if (child == 0) {
    const std::string text = work();
    const bool written = write(ends[1], text.data(), text.size()) == static_cast<ssize_t>(text.size());
    _exit(written ? 0 : 1);
  }
  close(ends[1]);
  std::string text;
  std::array<char, 4096> buffer{};
  for (ssize_t n = 0; (n = read(ends[0], buffer.data(), buffer.size())) > 0;)
    text.append(buffer.data(), static_cast<std::size_t>(n));
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  BOOST_TEST(status == 0);
  return text;
}

/// Runs `work` in a child process without capabilities and with these limits, and returns the text it makes.
std::string without_privileges(rlim_t rtprio, rlim_t memlock, const std::function<std::string()>& work) {
  return in_a_child([&]() -> std::string {
    const rlimit realtime{rtprio, rtprio};
    const rlimit locked{memlock, memlock};
    const rlimit nothing{0, 0};
    __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
    const std::array<__user_cap_data_struct, _LINUX_CAPABILITY_U32S_3> none{};
    const bool dropped = setrlimit(RLIMIT_RTPRIO, &realtime) == 0 && setrlimit(RLIMIT_MEMLOCK, &locked) == 0 &&
                         setrlimit(RLIMIT_NICE, &nothing) == 0 && syscall(SYS_capset, &header, none.data()) == 0;
    return dropped ? work() : "cannot drop privileges";
  });
}

std::string summary(const ThreadGrant& grant) {
  std::string text = std::to_string(static_cast<int>(grant.granted.policy)) + "/" +
                     std::to_string(grant.granted.priority) + "/" + std::to_string(sched_getscheduler(0)) + "/" +
                     std::to_string(prctl(PR_GET_TIMERSLACK, 0UL, 0UL, 0UL, 0UL)) + "/" + std::to_string(grant.nice) +
                     "\n";
  for (const Refusal& refusal : grant.refused) text += describe(refusal) + "\n";
  return text;
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// KiB of this process that are locked.
long locked_kib() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmLck:")) return std::strtol(line.c_str() + 6, nullptr, 10);
  }
  return -1;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_plain_thread_gets_a_name_and_a_fine_timer) {
  on_a_thread([] {
    const ThreadGrant grant = apply_thread_settings({}, "a name that is too long");
    BOOST_TEST((grant.granted == ThreadSettings{}));
    BOOST_TEST(grant.refused.empty());
    std::array<char, 16> name{};
    pthread_getname_np(pthread_self(), name.data(), name.size());
    BOOST_TEST(std::string(name.data()) == "a name that is ");
    BOOST_TEST(prctl(PR_GET_TIMERSLACK, 0UL, 0UL, 0UL, 0UL) == 1);
    BOOST_TEST(sched_getscheduler(0) == SCHED_OTHER);
  });
}

BOOST_AUTO_TEST_CASE(fifo_and_round_robin_are_granted_where_allowed, *utf::precondition(may_fifo)) {
  on_a_thread([] {
    BOOST_TEST((apply_thread_settings(fifo_40, "fifo").granted == fifo_40));
    sched_param parameter{};
    sched_getparam(0, &parameter);
    BOOST_TEST(sched_getscheduler(0) == SCHED_FIFO);
    BOOST_TEST(parameter.sched_priority == 40);
    const ThreadSettings turns{SchedulingPolicy::round_robin, 3, std::nullopt};
    BOOST_TEST((apply_thread_settings(turns, "turns").granted == turns));
    BOOST_TEST(sched_getscheduler(0) == SCHED_RR);
  });
}

BOOST_AUTO_TEST_CASE(a_thread_made_by_a_real_time_thread_gets_what_it_asks_for, *utf::precondition(may_fifo)) {
  on_a_thread([] {
    apply_thread_settings(fifo_40, "parent");
    on_a_thread([] {
      BOOST_TEST(sched_getscheduler(0) == SCHED_FIFO);
      apply_thread_settings({}, "child");
      BOOST_TEST(sched_getscheduler(0) == SCHED_OTHER);
    });
  });
}

BOOST_AUTO_TEST_CASE(a_loop_runs_under_what_it_was_granted, *utf::precondition(may_fifo)) {
  std::atomic<int> policy{-1};
  PeriodicLoop loop({.name = "fifo", .thread = fifo_40}, [&](const Tick&) { policy = sched_getscheduler(0); });
  const ThreadGrant grant = loop.start(MonotonicClock::now());
  while (loop.metrics().ended.value() < 3) std::this_thread::yield();
  BOOST_TEST(loop.stop(Duration{10'000'000'000}));
  BOOST_TEST((grant.granted == fifo_40));
  BOOST_TEST(policy == SCHED_FIFO);
}

BOOST_AUTO_TEST_CASE(a_thread_is_pinned_to_the_core_it_names) {
  cpu_set_t allowed;
  CPU_ZERO(&allowed);
  BOOST_REQUIRE(sched_getaffinity(0, sizeof allowed, &allowed) == 0);
  int last = 0;
  for (int core = 0; core < CPU_SETSIZE; ++core) last = CPU_ISSET(core, &allowed) ? core : last;
  on_a_thread([last] {
    const ThreadSettings pinned{SchedulingPolicy::other, 0, last};
    const ThreadGrant grant = apply_thread_settings(pinned, "pinned");
    BOOST_TEST((grant.granted == pinned));
    BOOST_TEST(sched_getcpu() == last);
  });
}

BOOST_AUTO_TEST_CASE(a_core_that_is_not_there_is_refused_with_those_that_are) {
  for (const int core : {-1, 1000, CPU_SETSIZE, 1'000'000}) {
    on_a_thread([core] {
      const ThreadGrant grant = apply_thread_settings({SchedulingPolicy::other, 0, core}, "nowhere");
      BOOST_TEST(!grant.granted.cpu);
      BOOST_REQUIRE(grant.refused.size() == 1U);
      const std::string text = describe(grant.refused.front());
      BOOST_TEST(contains(text, "core " + std::to_string(core) + " refused"), text);
      BOOST_TEST(contains(text, "may use the cores "), text);
      BOOST_TEST(contains(text, "to fix it: name one of"), text);
    });
  }
}

BOOST_AUTO_TEST_CASE(without_privileges_fifo_becomes_other_with_a_fine_timer_and_the_mend_is_told) {
  const std::string text =
      without_privileges(0, 65'536, [] { return summary(apply_thread_settings(fifo_40, "degraded")); });
  BOOST_TEST(text.starts_with("0/0/0/1/" + std::to_string(getpriority(PRIO_PROCESS, 0)) + "\n"), text);
  BOOST_TEST(contains(text, "SCHED_FIFO at priority 40 refused: the limit rtprio is 0"), text);
  BOOST_TEST(contains(text, geteuid() == 0 ? "--cap-add SYS_NICE" : "/etc/security/limits.d/"), text);
}

BOOST_AUTO_TEST_CASE(in_a_group_without_budget_niceness_stands_in_and_the_file_to_write_is_told,
                     *utf::precondition(may_make_groups)) {
  const GroupWithoutBudget group;
  const std::string text = in_a_child([&group]() -> std::string {
    return group.join() ? summary(apply_thread_settings(fifo_40, "no budget")) : "cannot join the group";
  });
  BOOST_TEST(text.starts_with("0/0/0/1/-20\n"), text);
  BOOST_TEST(contains(text, "no real-time budget"), text);
  BOOST_TEST(contains(text, "/cpu.rt_runtime_us"), text);
}

BOOST_AUTO_TEST_CASE(a_lower_limit_gives_the_priority_that_it_allows, *utf::precondition(may_fifo_and_limit_it)) {
  const std::string text =
      without_privileges(10, 65'536, [] { return summary(apply_thread_settings(fifo_40, "lower")); });
  BOOST_TEST(text.starts_with("1/10/1/"), text);
  BOOST_TEST(contains(text, "the limit rtprio is 10"), text);
}

BOOST_AUTO_TEST_CASE(a_limit_that_is_high_enough_needs_no_capability, *utf::precondition(may_fifo_and_limit_it)) {
  const std::string text =
      without_privileges(95, 65'536, [] { return summary(apply_thread_settings(fifo_40, "limit")); });
  BOOST_TEST(text.starts_with("1/40/1/"), text);
  BOOST_TEST(!contains(text, "refused"), text);
}

BOOST_AUTO_TEST_CASE(under_a_memory_limit_nothing_is_locked_and_allocating_still_works) {
  const std::string text = without_privileges(0, rlim_t{8} * 1024 * 1024, [] {
    const MemoryLock lock;
    std::string told = lock.locked() ? "locked\n" : describe(*lock.refused()) + "\n";
    const std::string large(std::size_t{32} * 1024 * 1024, 'x');
    return told + std::to_string(locked_kib()) + " KiB, " + large.back();
  });
  BOOST_TEST(text.starts_with("locking memory refused: the limit memlock is 8192 KiB"), text);
  BOOST_TEST(contains(text, "memlock"), text);
  BOOST_TEST(contains(text, "\n0 KiB, x"), text);
}

BOOST_AUTO_TEST_CASE(missing_privileges_are_told_once_each_and_nothing_is_changed_by_asking) {
  const std::string text = without_privileges(0, 65'536, [] {
    const std::array threads{fifo_40, fifo_40, ThreadSettings{}};
    const std::vector<Refusal> missing = missing_privileges(threads);
    std::string told = std::to_string(missing.size()) + " " + std::to_string(sched_getscheduler(0)) + " " +
                       std::to_string(locked_kib()) + "\n";
    for (const Refusal& refusal : missing) told += refusal.what + ";";
    return told;
  });
  BOOST_TEST(text == "2 0 0\nSCHED_FIFO at priority 40;locking memory;");
}

BOOST_AUTO_TEST_CASE(with_privileges_nothing_is_missing_and_memory_is_locked, *utf::precondition(may_fifo)) {
  if (memory_lock_refusal()) return;
  BOOST_TEST(missing_privileges(std::array{fifo_40}).empty());
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  // The sanitizers turn mlockall into nothing, their shadow being far larger than memory.
  {
    const MemoryLock lock;
    BOOST_TEST(lock.locked());
    BOOST_TEST(locked_kib() > 1000);
  }
  BOOST_TEST(locked_kib() == 0);
#endif
}

BOOST_AUTO_TEST_SUITE_END()
