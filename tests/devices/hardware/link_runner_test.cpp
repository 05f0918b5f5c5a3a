// The thread that talks to a device: cuts, reconnects, commands that grow old.
#include <sched.h>

#include <boost/test/unit_test.hpp>
#include <chrono>

#include "devices/hardware/link_runner.hpp"
#include "tests/devices/hardware/scripted_link.hpp"

BOOST_AUTO_TEST_SUITE(link_runner_test)

using namespace tactor;
using tactor::test::eventually;
using tactor::test::LinkScript;
using tactor::test::ScriptedLink;

namespace {

/// 10 N and 2 m/s.
AxisLimits one_axis() {
  AxisLimits limits;
  limits.effort_max = {10};
  limits.speed_max = {2};
  limits.jump_tolerance = {1e-3};
  return limits;
}

struct Rig {
  LinkScript script;
  LinkRunner runner;
  LinkReport report;

  explicit Rig(LinkRunnerSettings settings = {})
      : runner(std::make_unique<ScriptedLink>(script), one_axis(), settings) {}
  void command(double effort) { runner.command(MonotonicClock::now(), {{effort}}); }
  /// Commands again and again, as a loop does, until the condition holds.
  bool commanding(double effort, const std::function<bool()>& condition) {
    return eventually([&] {
      command(effort);
      runner.newest(report);
      return condition();
    });
  }
};

LinkRunnerSettings patient() {
  LinkRunnerSettings settings;
  settings.commands.age_max = settings.commands.expires_after = Duration{20'000'000'000};
  settings.idle_after = Duration{60'000'000'000};
  settings.back_off = Duration{1'000'000};
  return settings;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_command_passes_after_zero_has_been_commanded_once) {
  Rig rig(patient());
  rig.runner.start();
  BOOST_TEST(rig.commanding(3, [&] { return rig.script.cycles > 20; }));
  for (const double effort : rig.script.given()) BOOST_TEST((effort == 0 || effort == test::opening_mark));
  BOOST_TEST(rig.commanding(0, [&, from = rig.script.cycles.load()] { return rig.script.cycles > from + 3; }));
  BOOST_TEST(rig.commanding(3, [&] { return rig.script.effort == 3.0; }));
}

BOOST_AUTO_TEST_CASE(after_a_reconnect_the_command_is_cut_until_zero_is_commanded) {
  Rig rig(patient());
  rig.runner.start();
  BOOST_TEST(rig.commanding(0, [&] { return rig.script.cycles > 3; }));
  BOOST_TEST(rig.commanding(3, [&] { return rig.script.effort == 3.0; }));
  const std::uint64_t cuts = rig.report.cuts;
  rig.script.reopen = true;
  rig.script.fails = 1;
  BOOST_TEST(rig.commanding(3, [&] { return rig.script.openings == 2 && rig.report.cuts == cuts + 1; }));
  BOOST_TEST(rig.commanding(3, [&, from = rig.script.cycles.load()] { return rig.script.cycles > from + 20; }));
  std::vector<double> given = rig.script.given();
  std::size_t opened = given.size();
  while (given[--opened] != test::opening_mark) {
  }
  for (std::size_t i = opened + 1; i < given.size(); ++i) BOOST_TEST(given[i] == 0.0);
  BOOST_TEST(given.size() > opened + 10);
  BOOST_TEST(rig.commanding(0, [&, from = rig.script.cycles.load()] { return rig.script.cycles > from + 3; }));
  BOOST_TEST(rig.commanding(2, [&] { return rig.script.effort == 2.0; }));
  BOOST_TEST(rig.runner.metrics().reconnects.value() == 1);
  BOOST_TEST(rig.runner.metrics().errors(LinkError::timeout) == 1);
}

BOOST_AUTO_TEST_CASE(a_command_of_a_loop_that_has_stopped_counts_as_zero_and_the_device_is_shut_down) {
  LinkRunnerSettings settings = patient();
  settings.commands.age_max = settings.commands.expires_after = Duration{300'000'000};
  settings.idle_after = Duration{600'000'000};
  Rig rig(settings);
  rig.runner.start();
  BOOST_TEST(rig.commanding(0, [&] { return rig.script.cycles > 3; }));
  BOOST_TEST(rig.commanding(3, [&] { return rig.script.effort == 3.0; }));
  BOOST_TEST(eventually([&] { return rig.script.effort == 0.0; }));
  BOOST_TEST(eventually([&] { return rig.script.closings == 1; }));
  // A loop that goes on with its force does not get it back before it has commanded zero.
  BOOST_TEST(rig.commanding(3, [&] { return rig.script.openings == 2; }));
  BOOST_TEST(rig.commanding(3, [&, from = rig.script.cycles.load()] { return rig.script.cycles > from + 20; }));
  BOOST_TEST(rig.script.effort == 0.0);
}

BOOST_AUTO_TEST_CASE(failures_in_a_row_open_the_line_anew_and_single_ones_do_not) {
  Rig rig(patient());
  rig.runner.start();
  BOOST_TEST(eventually([&] { return rig.script.cycles > 3; }));
  rig.script.fails = 4;
  BOOST_TEST(eventually([&] { return rig.script.fails == 0; }));
  BOOST_TEST(eventually([&, from = rig.script.cycles.load()] { return rig.script.cycles > from + 3; }));
  BOOST_TEST(rig.script.openings == 1);
  rig.script.fails = 5;
  BOOST_TEST(eventually([&] { return rig.script.openings == 2; }));
  BOOST_TEST(rig.runner.metrics().errors(LinkError::timeout) == 9);
  BOOST_TEST(rig.runner.last_failure() == "test rig at port 7: no answer within 5 ms");
}

BOOST_AUTO_TEST_CASE(a_line_that_cannot_be_opened_is_tried_again_with_growing_pauses) {
  LinkRunnerSettings settings = patient();
  settings.back_off = Duration{20'000'000};
  settings.back_off_max = Duration{100'000'000};
  Rig rig(settings);
  rig.script.opens = false;
  const Instant began = MonotonicClock::now();
  rig.runner.start();
  BOOST_TEST(eventually([&] { return rig.script.attempts == 5; }));
  // 20 + 40 + 80 + 100 ms at least lie between five attempts.
  BOOST_TEST((MonotonicClock::now() - began).seconds() >= 0.24);
  BOOST_TEST(rig.runner.metrics().errors(LinkError::disconnected) >= 4);
  rig.script.opens = true;
  BOOST_TEST(eventually([&] { return rig.script.cycles > 3; }));
}

BOOST_AUTO_TEST_CASE(a_line_that_opens_and_never_has_a_good_cycle_is_tried_with_growing_pauses_too) {
  LinkRunnerSettings settings = patient();
  settings.back_off = Duration{20'000'000};
  settings.back_off_max = Duration{100'000'000};
  Rig rig(settings);
  rig.script.reopen = true;
  rig.script.fails = 1 << 30;
  const Instant began = MonotonicClock::now();
  rig.runner.start();
  BOOST_TEST(eventually([&] { return rig.script.openings == 5; }));
  BOOST_TEST((MonotonicClock::now() - began).seconds() >= 0.24);
  rig.script.fails = 0;
  BOOST_TEST(eventually([&] { return rig.script.cycles > 3; }));
}

BOOST_AUTO_TEST_CASE(a_zero_between_two_cycles_of_a_slow_line_ends_the_cut) {
  LinkRunnerSettings settings = patient();
  settings.rate = 2;
  Rig rig(settings);
  rig.runner.start();
  BOOST_TEST(rig.commanding(3, [&] { return rig.script.cycles > 1; }));
  BOOST_TEST(rig.script.effort == 0.0);
  rig.command(0);
  BOOST_TEST(rig.commanding(3, [&] { return rig.script.effort == 3.0; }));
}

BOOST_AUTO_TEST_CASE(the_thread_of_the_line_runs_one_priority_below_the_loop_or_like_it) {
  struct Asked {
    int policy, priority, expected;
  };
  for (const Asked asked : {Asked{SCHED_FIFO, 20, 19}, Asked{SCHED_FIFO, 1, 1}, Asked{SCHED_OTHER, 0, 0}}) {
    Rig rig(patient());
    bool may = true;
    std::atomic<bool> told{false};
    std::thread loop([&] {
      const sched_param parameter{asked.priority};
      may = sched_setscheduler(0, asked.policy, &parameter) == 0;
      rig.command(0);
      told = true;
    });
    loop.join();
    if (!may) continue;  // this user may not
    rig.runner.start();
    BOOST_TEST(eventually([&] { return told && rig.script.cycles > 3; }));
    BOOST_TEST(rig.script.policy == asked.policy);
    BOOST_TEST(rig.script.priority == asked.expected);
    BOOST_TEST(rig.runner.refused().empty());
  }
}

BOOST_AUTO_TEST_CASE(stopping_closes_what_is_open_once) {
  LinkScript script;
  {
    LinkRunner runner(std::make_unique<ScriptedLink>(script), one_axis(), patient());
    runner.start();
    BOOST_TEST(eventually([&] { return script.cycles > 3; }));
    runner.stop();
    BOOST_TEST(script.closings == 1);
  }
  BOOST_TEST(script.closings == 1);
}

BOOST_AUTO_TEST_CASE(cycles_that_are_due_in_another_are_skipped) {
  LinkRunnerSettings settings = patient();
  settings.rate = 200;
  Rig rig(settings);
  rig.script.slow = true;
  rig.runner.start();
  BOOST_TEST(eventually([&] { return rig.script.cycles >= 5; }));
  rig.runner.stop();
  BOOST_TEST(rig.runner.metrics().skipped.value() >= 4 * 5);
}

BOOST_AUTO_TEST_CASE(a_line_that_sets_the_pace_goes_ahead_of_the_deadlines_by_one_and_a_half_periods) {
  for (const bool sets_pace : {false, true}) {
    LinkRunnerSettings settings = patient();
    settings.rate = 2;
    LinkScript script;
    script.pace = sets_pace ? LinkPace::device : LinkPace::deadlines;
    LinkRunner runner(std::make_unique<ScriptedLink>(script), one_axis(), settings);
    const auto begin = std::chrono::steady_clock::now();
    runner.start();
    BOOST_TEST_REQUIRE(eventually([&] { return script.cycles >= 4; }));
    runner.stop();
    const std::scoped_lock lock(script.mutex);
    // Cycle k is due k periods of 0.5 s after the opening, and never begins more than 0.75 s before.
    for (int k = 0; k < 4; ++k) {
      const double due = 0.5 * k - (sets_pace ? 0.75 : 0.0);
      const std::chrono::duration<double> at = script.begins[static_cast<std::size_t>(k)] - begin;
      BOOST_TEST(at.count() >= due - 1e-3);
    }
    const std::chrono::duration<double> second = script.begins[1] - script.begins[0];
    // Two cycles of half a second apart fit into less where the device is waited for, unless the machine stands still.
    if (sets_pace) BOOST_TEST(second.count() < 0.4);
  }
}

BOOST_AUTO_TEST_SUITE_END()
