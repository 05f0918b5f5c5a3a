// What a process that crashes in a run leaves behind: children that crash in different ways, and a parent that reads.
#include "app/study/run/crash_board.hpp"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <boost/test/unit_test.hpp>
#include <csignal>
#include <cstdlib>
#include <functional>
#include <latch>
#include <thread>

using namespace tactor;

namespace {

/// The signal that ended a child in which `work` ran; 0 where it ended well.
int ended_by(CrashBoard& board, const std::function<void()>& work) {
  board.begin();
  const pid_t child = fork();
  if (child == 0) {
    const rlimit no_core{0, 0};
    setrlimit(RLIMIT_CORE, &no_core);
    // What the test's own library does about signals is not wanted here.
    for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT}) std::signal(signal, SIG_DFL);
    {
      const CrashSignals signals(&board);
      const CrashStack stack;
      work();
    }
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFSIGNALED(status) ? WTERMSIG(status) : 0;
}

int run_over(volatile const int* deeper) {
  if (*deeper == 0) return 0;  // it never is
  volatile int here[1024] = {*deeper};
  return run_over(here) + here[1];
}

bool is(const std::vector<RunPlace>& found, const std::vector<RunPlace>& expected) {
  return found == expected;
}

}  // namespace

BOOST_AUTO_TEST_CASE(the_thread_that_crashes_is_told_from_others) {
  CrashBoard board(2);
  BOOST_TEST(ended_by(board, [&board] {
               std::latch both(2);
               std::thread other([&] {
                 const CrashPlace place(&board, {RunStage::run, 7});
                 both.arrive_and_wait();
                 for (;;) pause();
               });
               const CrashPlace place(&board, {RunStage::reference, 12});
               both.arrive_and_wait();
               raise(SIGFPE);
               other.join();
             }) == SIGFPE);
  BOOST_TEST(is(board.places(), {{RunStage::reference, 12}}));
  BOOST_TEST(board.signal() == SIGFPE);
  BOOST_TEST(signal_word(SIGFPE) == "SIGFPE");
}

BOOST_AUTO_TEST_CASE(what_comes_from_outside_leaves_all_that_were_under_way) {
  CrashBoard board(3);
  for (const int signal : {SIGSEGV, SIGKILL}) {
    BOOST_TEST(ended_by(board, [&board, signal] {
                 const CrashPlace first(&board, {RunStage::run, 3});
                 const CrashPlace second(&board, {RunStage::run, 0});
                 { const CrashPlace over(&board, {RunStage::run, 9}); }
                 const pid_t parent = getpid();
                 if (fork() == 0) {
                   kill(parent, signal);
                   _exit(0);
                 }
                 for (;;) pause();
               }) == signal);
    BOOST_TEST(is(board.places(), {{RunStage::run, 3}, {RunStage::run, 0}}));
    BOOST_TEST(board.signal() == 0);
  }
}

BOOST_AUTO_TEST_CASE(a_stack_that_ran_over_is_told) {
  CrashBoard board(1);
  BOOST_TEST(ended_by(board, [&board] {
               const CrashPlace place(&board, {RunStage::planning, 3});
               const volatile int begin = 1;
               std::exit(run_over(&begin));
             }) == SIGSEGV);
  BOOST_TEST(is(board.places(), {{RunStage::planning, 3}}));
  BOOST_TEST(board.signal() == SIGSEGV);
}

BOOST_AUTO_TEST_CASE(a_crash_outside_of_any_run_has_no_place) {
  CrashBoard board(1);
  BOOST_TEST(ended_by(board, [&board] {
               { const CrashPlace place(&board, {RunStage::run, 3}); }
               std::abort();
             }) == SIGABRT);
  BOOST_TEST(board.places().empty());
}

BOOST_AUTO_TEST_CASE(counts_outlive_processes_and_places_do_not) {
  CrashBoard board(1);
  for (int i = 0; i < 2; ++i) {
    BOOST_TEST(ended_by(board, [&board] {
                 if (board.trial() || !board.places().empty()) return;
                 board.count_row();
                 board.set_has_table();
                 board.set_trial(5);
                 const CrashPlace place(&board, {RunStage::run, 5});
                 raise(SIGKILL);
               }) == SIGKILL);
    BOOST_TEST((board.trial() == std::optional<std::size_t>(5)));
  }
  BOOST_TEST(board.rows() == 2U);
  BOOST_TEST(board.has_table());
}
