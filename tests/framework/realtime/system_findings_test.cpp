// The probe reads the files of a machine that the test made up, and each fact is judged as it should be.
#include "framework/realtime/system_findings.hpp"

#include <sys/utsname.h>

#include <boost/test/unit_test.hpp>
#include <filesystem>
#include <fstream>
#include <string>

#include "framework/core/temporary_folder.hpp"
#include "framework/realtime/loop_trial.hpp"

BOOST_TEST_DONT_PRINT_LOG_VALUE(tactor::Grade)
BOOST_TEST_DONT_PRINT_LOG_VALUE(tactor::Preemption)

BOOST_AUTO_TEST_SUITE(system_findings_test)

using namespace tactor;
namespace fs = std::filesystem;

namespace {

/// A folder that stands for the root of another machine.
class Machine {
 public:
  void file(const std::string& path, const std::string& text) const {
    fs::create_directories((root() / path).parent_path());
    std::ofstream(root() / path) << text;
  }
  [[nodiscard]] const fs::path& root() const { return folder_.path(); }

 private:
  TemporaryFolder folder_;
};

Finding finding(const SystemFacts& facts, const std::string& id) {
  for (const Finding& candidate : judge(facts)) {
    if (candidate.id == id) return candidate;
  }
  BOOST_FAIL("no finding " << id);
  return {};
}

Grade grade(const SystemFacts& facts, const std::string& id) {
  const Finding found = finding(facts, id);
  // What is not ok says what it costs and what would help.
  BOOST_TEST((found.grade == Grade::ok) == found.cost.empty(), id);
  BOOST_TEST((found.grade == Grade::ok) == found.remedy.empty(), id);
  BOOST_TEST(!found.found.empty(), id);
  BOOST_TEST(found.title.size() <= 16U, id);
  return found.grade;
}

SystemFacts good_machine() {
  SystemFacts facts;
  facts.kernel = "6.1.0-rt PREEMPT_RT";
  facts.least_nice = -20;
  facts.cores = 8;
  facts.isolated_cores = "6-7";
  facts.preemption = Preemption::realtime;
  facts.governors = {"performance"};
  facts.idle_exit_latency_us = 2;
  facts.rt_runtime_us = 950'000;
  facts.rt_period_us = 1'000'000;
  facts.timer_slack_ns = 50'000;
  facts.clock_source = "tsc";
  return facts;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_good_machine_is_ok_in_everything) {
  const SystemFacts facts = good_machine();
  for (const Finding& found : judge(facts)) BOOST_TEST(grade(facts, found.id) == Grade::ok, found.id);
  BOOST_TEST(worst(judge(facts)) == Grade::ok);
}

BOOST_AUTO_TEST_CASE(each_shortcoming_is_degraded_on_its_own) {
  const auto degraded = [](const std::string& id, auto&& spoil) {
    SystemFacts facts = good_machine();
    spoil(facts);
    for (const Finding& found : judge(facts)) {
      BOOST_TEST(grade(facts, found.id) == (found.id == id ? Grade::degraded : Grade::ok), id << " " << found.id);
    }
    BOOST_TEST(worst(judge(facts)) == Grade::degraded);
  };
  degraded("fifo", [](SystemFacts& f) { f.fifo_refused = Refusal{"SCHED_FIFO", "no", "a line"}; });
  degraded("memory_lock", [](SystemFacts& f) { f.memory_lock_refused = Refusal{"lock", "no", "a line"}; });
  degraded("cores", [](SystemFacts& f) { f.cores = 1; });
  degraded("preemption", [](SystemFacts& f) { f.preemption = Preemption::none; });
  degraded("preemption", [](SystemFacts& f) { f.preemption = Preemption::voluntary; });
  degraded("preemption", [](SystemFacts& f) { f.preemption = Preemption::unknown; });
  degraded("governor", [](SystemFacts& f) { f.governors = {"performance", "powersave"}; });
  degraded("throttling", [](SystemFacts& f) { f.thermal_throttlings = 3; });
  degraded("idle_states", [](SystemFacts& f) { f.idle_exit_latency_us = 133; });
  degraded("rt_throttling", [](SystemFacts& f) { f.rt_runtime_us = 500'000; });
  degraded("cgroup", [](SystemFacts& f) { f.cgroup = CgroupRealtime{"/sys/fs/cgroup/cpu/a/cpu.rt_runtime_us", 0}; });
  degraded("clock_source", [](SystemFacts& f) { f.clock_source = "hpet"; });
  degraded("machine", [](SystemFacts& f) { f.virtual_machine = true; });
}

BOOST_AUTO_TEST_CASE(no_time_at_all_for_real_time_threads_is_bad) {
  SystemFacts facts = good_machine();
  facts.rt_runtime_us = 0;
  BOOST_TEST(grade(facts, "rt_throttling") == Grade::bad);
  BOOST_TEST(worst(judge(facts)) == Grade::bad);
  BOOST_TEST(finding(facts, "rt_throttling").remedy == "sudo sysctl -w kernel.sched_rt_runtime_us=950000");
}

BOOST_AUTO_TEST_CASE(throttling_that_is_off_is_ok_and_said) {
  SystemFacts facts = good_machine();
  facts.rt_runtime_us = -1;
  BOOST_TEST(grade(facts, "rt_throttling") == Grade::ok);
  BOOST_TEST(finding(facts, "rt_throttling").found.starts_with("off"));
}

BOOST_AUTO_TEST_CASE(nice_matters_only_where_fifo_is_refused) {
  SystemFacts facts = good_machine();
  facts.least_nice = 0;
  BOOST_TEST(grade(facts, "nice") == Grade::ok);
  facts.fifo_refused = Refusal{"SCHED_FIFO", "no", "a line"};
  BOOST_TEST(grade(facts, "nice") == Grade::degraded);
}

BOOST_AUTO_TEST_CASE(the_mend_of_a_kernel_fits_the_kernel) {
  SystemFacts facts = good_machine();
  facts.preemption = Preemption::none;
  facts.kernel = "6.1 SMP PREEMPT_DYNAMIC";
  BOOST_TEST(finding(facts, "preemption").remedy.find("preempt=full") != std::string::npos);
  facts.kernel = "6.1 SMP";
  BOOST_TEST(finding(facts, "preemption").remedy.find("linux-image-rt") != std::string::npos);
}

BOOST_AUTO_TEST_CASE(the_files_of_a_machine_are_read) {
  const Machine machine;
  const std::string cpu = "sys/devices/system/cpu/";
  machine.file(cpu + "isolated", "2-3\n");
  machine.file(cpu + "cpu0/cpufreq/scaling_governor", "powersave\n");
  machine.file(cpu + "cpu1/cpufreq/scaling_governor", "performance\n");
  machine.file(cpu + "cpu10/cpufreq/scaling_governor", "powersave\n");
  machine.file(cpu + "cpufreq/scaling_governor", "not a core\n");
  machine.file(cpu + "cpu0/thermal_throttle/core_throttle_count", "2\n");
  machine.file(cpu + "cpu10/thermal_throttle/package_throttle_count", "5\n");
  machine.file(cpu + "cpu0/cpuidle/state0/latency", "1\n");
  machine.file(cpu + "cpu0/cpuidle/state1/latency", "85\n");
  machine.file(cpu + "cpu0/cpuidle/state2/latency", "200\n");
  machine.file(cpu + "cpu0/cpuidle/state2/disable", "1\n");
  machine.file("proc/sys/kernel/sched_rt_runtime_us", "400000\n");
  machine.file("proc/sys/kernel/sched_rt_period_us", "500000\n");
  machine.file("sys/devices/system/clocksource/clocksource0/current_clocksource", "acpi_pm\n");
  machine.file("proc/cpuinfo", "processor : 0\nflags : fpu hypervisor lm\n");
  machine.file("sys/class/dmi/id/sys_vendor", "QEMU\n");
  machine.file("sys/class/dmi/id/product_name", "Standard PC\n");
  machine.file("proc/stat", "cpu  100 0 100 700 50 0 0 50 30 0\ncpu0 1 2 3\n");
  machine.file("sys/kernel/realtime", "1\n");
  const SystemFacts facts = probe_system(machine.root());
  BOOST_TEST(facts.isolated_cores == "2-3");
  BOOST_TEST(facts.governors == (std::vector<std::string>{"performance", "powersave"}));
  BOOST_TEST(facts.thermal_throttlings == 7);
  BOOST_TEST(facts.idle_exit_latency_us == 85);
  BOOST_TEST(facts.rt_runtime_us.value() == 400'000);
  BOOST_TEST(facts.rt_period_us == 500'000);
  BOOST_TEST(facts.clock_source == "acpi_pm");
  BOOST_TEST(facts.virtual_machine);
  BOOST_TEST(facts.product == "QEMU Standard PC");
  BOOST_TEST(std::abs(facts.steal_share - 0.05) < 1e-12);
  BOOST_TEST(facts.preemption == Preemption::realtime);
}

BOOST_AUTO_TEST_CASE(a_machine_that_shows_nothing_is_read_too) {
  const Machine machine;
  const SystemFacts facts = probe_system(machine.root());
  BOOST_TEST(facts.governors.empty());
  BOOST_TEST(!facts.rt_runtime_us);
  BOOST_TEST(!facts.virtual_machine);
  BOOST_TEST(facts.steal_share == 0);
  BOOST_TEST(facts.cores >= 1);
  BOOST_TEST(facts.timer_slack_ns > 0);
  for (const Finding& found : judge(facts)) BOOST_TEST(!found.found.empty(), found.id);
}

BOOST_AUTO_TEST_CASE(the_mode_of_a_switchable_kernel_is_read_where_it_is_shown) {
  utsname name{};
  uname(&name);
  if (std::string(name.version).find("PREEMPT_DYNAMIC") == std::string::npos) {
    BOOST_TEST_MESSAGE("this kernel is not switchable");
    return;
  }
  const Machine machine;
  BOOST_TEST(probe_system(machine.root()).preemption == Preemption::unknown);
  machine.file(std::string("boot/config-") + name.release, "# CONFIG_PREEMPT is not set\nCONFIG_PREEMPT_NONE=y\n");
  BOOST_TEST(probe_system(machine.root()).preemption == Preemption::none);
  machine.file("proc/cmdline", "quiet preempt=voluntary\n");
  BOOST_TEST(probe_system(machine.root()).preemption == Preemption::voluntary);
  machine.file("sys/kernel/debug/sched/preempt", "none voluntary (full) lazy\n");
  BOOST_TEST(probe_system(machine.root()).preemption == Preemption::full);
}

BOOST_AUTO_TEST_CASE(a_trial_runs_for_its_length) {
  for (const bool beside_load : {false, true}) {
    const LoopTrial trial = try_loop({}, 1000, Duration{200'000'000}, beside_load);
    BOOST_TEST((trial.granted == ThreadSettings{}));
    BOOST_TEST(trial.beside_load == beside_load);
    BOOST_TEST(trial.ticks > 0);
    // The last of its ticks may still be due when a thread that is starved is told to stop.
    BOOST_TEST(trial.ticks + trial.missed > 100);
    BOOST_TEST((trial.p50 > Duration{0} && trial.p50 <= trial.p99 && trial.p99 <= trial.max));
  }
}

BOOST_AUTO_TEST_CASE(the_cost_of_the_loop_itself_is_above_nothing) {
  BOOST_TEST(measure_bookkeeping().ns > 0);
}

BOOST_AUTO_TEST_SUITE_END()
