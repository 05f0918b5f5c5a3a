// Who is blamed for what: processes that a supervisor starts and that crash in different ways.
#include "app/study/run/supervisor.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <csignal>
#include <cstdlib>
#include <functional>
#include <optional>
#include <set>

using namespace tactor;

namespace {

/// Runs 0 to 4 of a table whose rows are in shared memory; `work` is what a run does. What `run_cases` does with a
/// supervisor, in short: what is given up is a row, suspects come first, the first of them as a trial.
class Table {
 public:
  explicit Table(std::function<void(const Table&, std::size_t run)> work)
      : work_(std::move(work)), supervisor(2), rows_(32) {}

  /// The exit code. `report` is what a process does when all runs are there.
  int watch(const std::function<void()>& report = [] {}) {
    const std::optional<int> code = supervisor.watch();
    if (code) return *code;
    const rlimit no_core{0, 0};
    setrlimit(RLIMIT_CORE, &no_core);
    for (const int signal : {SIGSEGV, SIGABRT}) std::signal(signal, SIG_DFL);
    bool first = true;
    for (const RunPlace& suspect : supervisor.suspects()) {
      if (has(suspect.number) || supervisor.lost().contains(suspect)) continue;
      if (first) supervisor.board().set_trial(suspect.number);
      make(suspect.number);
      first = false;
      supervisor.board().set_trial(std::nullopt);
    }
    for (std::size_t run = 0; run < 5; ++run) {
      if (!has(run) && !supervisor.lost().contains({RunStage::run, run})) make(run);
    }
    report();
    _exit(0);
  }

  /// Whether a run was made; told by the places of a second board.
  [[nodiscard]] bool has(std::size_t run) const {
    const std::vector<RunPlace> there = rows_.places();
    return std::find(there.begin(), there.end(), RunPlace{RunStage::run, run}) != there.end();
  }
  [[nodiscard]] std::set<std::size_t> rows() const {
    std::set<std::size_t> all;
    for (const RunPlace& place : rows_.places()) all.insert(place.number);
    return all;
  }

 private:
  void make(std::size_t run) {
    const CrashPlace place(&supervisor.board(), {RunStage::run, run});
    work_(*this, run);
    new CrashPlace(&rows_, {RunStage::run, run});  // it stays there for good
    supervisor.board().count_row();
  }

  std::function<void(const Table&, std::size_t run)> work_;

 public:
  Supervisor supervisor;

 private:
  CrashBoard rows_;
};

}  // namespace

BOOST_AUTO_TEST_CASE(what_ends_well_or_says_an_exit_code_is_not_tried_again) {
  Table table([](const Table&, std::size_t) {});
  BOOST_TEST(table.watch() == 0);
  BOOST_TEST(table.rows().size() == 5U);
  Table refused([](const Table&, std::size_t) {});
  BOOST_TEST(refused.watch([] { _exit(2); }) == 2);
  BOOST_TEST(refused.supervisor.crashes() == 0U);
}

BOOST_AUTO_TEST_CASE(runs_that_crash_twice_are_given_up_and_all_others_made) {
  Table table([](const Table&, std::size_t run) {
    if (run == 1) raise(SIGKILL);
    if (run == 2) std::abort();
    if (run == 4) _exit(3);
  });
  BOOST_TEST(table.watch() == 0);
  BOOST_TEST((table.rows() == std::set<std::size_t>{0, 3}));
  const auto& lost = table.supervisor.lost();
  BOOST_REQUIRE(lost.size() == 3U);
  BOOST_TEST(lost.at({RunStage::run, 1}).text == "killed (SIGKILL), perhaps for lack of memory");
  BOOST_TEST(lost.at({RunStage::run, 2}).text == "ended by SIGABRT");
  BOOST_TEST(lost.at({RunStage::run, 4}).text == "ended with exit code 3");
  BOOST_TEST(table.supervisor.crashes() == 6U);
}

BOOST_AUTO_TEST_CASE(a_run_that_crashes_for_what_an_earlier_one_broke_is_not_blamed) {
  // Run 3 crashes wherever run 0 was made in the same process.
  bool broken = false;
  Table table([&broken](const Table&, std::size_t run) {
    if (run == 0) broken = true;
    if (run == 3 && broken) std::abort();
  });
  BOOST_TEST(table.watch() == 0);
  BOOST_TEST(table.rows().size() == 5U);
  BOOST_TEST(table.supervisor.crashes() == 1U);
  BOOST_TEST(table.supervisor.lost().empty());
}

BOOST_AUTO_TEST_CASE(of_runs_beside_each_other_the_innocent_one_is_made) {
  // Run 2 is under way whenever run 1 is, as in another thread, unless that is tried alone.
  Table* all = nullptr;
  Table table([&all](const Table&, std::size_t run) {
    if (run != 1) return;
    CrashBoard& board = all->supervisor.board();
    std::optional<CrashPlace> beside;
    if (!board.trial()) beside.emplace(&board, RunPlace{RunStage::run, 2});
    raise(SIGKILL);
  });
  all = &table;
  BOOST_TEST(table.watch() == 0);
  BOOST_TEST((table.rows() == std::set<std::size_t>{0, 2, 3, 4}));
  BOOST_TEST(table.supervisor.lost().size() == 1U);
  BOOST_TEST(table.supervisor.lost().contains({RunStage::run, 1}));
}

BOOST_AUTO_TEST_CASE(a_run_that_hangs_is_ended_and_its_neighbour_not_blamed) {
  Table* all = nullptr;
  Table table([&all](const Table&, std::size_t run) {
    all->supervisor.board().set_timeout(1);
    if (run != 3) return;
    CrashBoard& board = all->supervisor.board();
    CrashPlace beside(&board, {RunStage::planning, 7});  // never overdue
    for (;;) pause();
  });
  all = &table;
  BOOST_TEST(table.watch() == 0);
  BOOST_TEST((table.rows() == std::set<std::size_t>{0, 1, 2, 4}));
  BOOST_REQUIRE(table.supervisor.lost().size() == 1U);
  BOOST_TEST(table.supervisor.lost().at({RunStage::run, 3}).text == "took longer than 1 s, the run_timeout");
}

BOOST_AUTO_TEST_CASE(crashes_that_bring_nothing_end) {
  // Two runs that are never told from each other.
  Table* all = nullptr;
  Table table([&all](const Table&, std::size_t) {
    const CrashPlace beside(&all->supervisor.board(), {RunStage::run, 2});
    raise(SIGKILL);
  });
  all = &table;
  BOOST_TEST(table.watch() == 1);
  BOOST_TEST(table.supervisor.crashes() == 3U);
  BOOST_TEST(table.rows().empty());
}

BOOST_AUTO_TEST_CASE(a_process_that_is_killed_between_runs_is_followed_by_another_one_three_times_at_most) {
  Table* all = nullptr;
  Table once([](const Table&, std::size_t) {});
  all = &once;
  BOOST_TEST(once.watch([&all] {
    if (all->supervisor.crashes() == 0) raise(SIGKILL);
  }) == 0);
  BOOST_TEST(once.supervisor.crashes() == 1U);
  BOOST_TEST(once.supervisor.lost().empty());
  Table always([](const Table&, std::size_t) {});
  BOOST_TEST(always.watch([] { raise(SIGKILL); }) == 1);
  BOOST_TEST(always.rows().size() == 5U);
  BOOST_TEST(always.supervisor.lost().empty());
}

BOOST_AUTO_TEST_CASE(a_crash_outside_of_any_run_is_told_and_not_tried_again) {
  Table table([](const Table&, std::size_t) {});
  BOOST_TEST(table.watch([] { std::abort(); }) == 1);
  BOOST_TEST(table.supervisor.crashes() == 1U);
  BOOST_TEST(table.rows().size() == 5U);
}
