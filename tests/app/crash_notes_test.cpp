// What a process that crashes in a run leaves behind: children that crash in different ways, and a parent that reads.
#include "app/study/crash_notes.hpp"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <boost/test/unit_test.hpp>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <functional>

#include "framework/core/temporary_folder.hpp"

using namespace tactor;

namespace {

/// The signal that ended a child in which `work` ran with notes in the file; 0 where it ended well.
int ended_by(const std::filesystem::path& file, const std::function<void()>& work) {
  const pid_t child = fork();
  if (child == 0) {
    const rlimit no_core{0, 0};
    setrlimit(RLIMIT_CORE, &no_core);
    // What the test's own library does about signals is not wanted here.
    for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT}) std::signal(signal, SIG_DFL);
    {
      const CrashNotes notes(file, "");
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

}  // namespace

BOOST_AUTO_TEST_CASE(crashes_are_noted_with_signal_and_run) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "t.crashes";
  BOOST_TEST(ended_by(file, [] {
               const CrashPlace place(7, false);
               std::abort();
             }) == SIGABRT);
  BOOST_TEST(ended_by(file, [] {
               const CrashPlace place(12, true);
               raise(SIGFPE);
             }) == SIGFPE);
  const std::vector<CrashNote> found = CrashNotes(file, "").found();
  BOOST_REQUIRE(found.size() == 2U);
  BOOST_TEST(found[0].signal == SIGABRT);
  BOOST_TEST(found[0].run == 7U);
  BOOST_TEST(!found[0].in_reference);
  BOOST_TEST(found[1].signal == SIGFPE);
  BOOST_TEST(found[1].run == 12U);
  BOOST_TEST(found[1].in_reference);
  BOOST_TEST(signal_word(SIGFPE) == "SIGFPE");
}

BOOST_AUTO_TEST_CASE(a_stack_that_ran_over_is_noted) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "t.crashes";
  BOOST_TEST(ended_by(file, [] {
               const CrashPlace place(3, false);
               const volatile int begin = 1;
               std::exit(run_over(&begin));
             }) == SIGSEGV);
  const std::vector<CrashNote> found = CrashNotes(file, "").found();
  BOOST_REQUIRE(found.size() == 1U);
  BOOST_TEST(found[0].run == 3U);
}

BOOST_AUTO_TEST_CASE(what_is_nobodys_run_or_comes_from_outside_is_not_noted) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "t.crashes";
  BOOST_TEST(ended_by(file, [] {
               { const CrashPlace place(3, false); }
               std::abort();
             }) == SIGABRT);
  for (const int signal : {SIGSEGV, SIGKILL}) {
    BOOST_TEST(ended_by(file, [signal] {
                 const CrashPlace place(3, false);
                 const pid_t parent = getpid();
                 if (fork() == 0) {
                   kill(parent, signal);
                   _exit(0);
                 }
                 for (;;) pause();
               }) == signal);
  }
  BOOST_TEST(CrashNotes(file, "").found().empty());
  // A file in which nothing is noted is taken away.
  BOOST_TEST(!std::filesystem::exists(file));
}

BOOST_AUTO_TEST_CASE(a_line_that_was_cut_off_is_left_out) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "t.crashes";
  std::ofstream(file) << "6 run 4\nnonsense\n11 reference 5\n6 run 1";
  const std::vector<CrashNote> found = CrashNotes(file, "").found();
  BOOST_REQUIRE(found.size() == 2U);
  BOOST_TEST(found[1].run == 5U);
}
