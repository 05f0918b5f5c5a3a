#include "app/study/run/supervisor.hpp"

#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <ctime>

#include "app/output.hpp"
#include "app/progress_bar.hpp"
#include "app/run/cpu_time.hpp"
#include "framework/core/check.hpp"
#include "framework/realtime/make_thread.hpp"

namespace tactor {

namespace {

/// Signals that a program brings upon itself, or that end one which takes all memory. Others come from a user.
constexpr std::array<int, 8> crash_signals{SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGSYS, SIGTRAP, SIGKILL};

/// Signals that the process which waits takes one by one.
sigset_t awaited() {
  sigset_t set;
  sigemptyset(&set);
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGCHLD}) {
    struct sigaction now {};
    sigaction(number, nullptr, &now);
    // nohup says that a closed terminal is no reason to end.
    if (number == SIGCHLD || now.sa_handler != SIG_IGN) sigaddset(&set, number);
  }
  return set;
}

/// While it lives, the signals wait until they are asked for.
class Blocked {
 public:
  explicit Blocked(const sigset_t& set) { sigprocmask(SIG_BLOCK, &set, &before_); }
  ~Blocked() { sigprocmask(SIG_SETMASK, &before_, nullptr); }
  Blocked(const Blocked&) = delete;
  Blocked& operator=(const Blocked&) = delete;

 private:
  sigset_t before_{};
};

Ending ending_by(int signal) {
  if (signal == SIGKILL) return {"killed (SIGKILL), perhaps for lack of memory", true};
  return {"ended by " + signal_word(signal)};
}

/// Ends this process as the other one ended.
int end_by(int signal) {
  std::signal(signal, SIG_DFL);
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, signal);
  sigprocmask(SIG_UNBLOCK, &set, nullptr);
  raise(signal);
  return 1;
}

}  // namespace

std::string took_longer(double seconds) {
  return fmt::format("took longer than {} s, the run_timeout", seconds);
}

Supervisor::Supervisor(unsigned threads) : board_(threads) {}

std::optional<int> Supervisor::watch() {
  std::signal(SIGCHLD, SIG_DFL);  // who started us may have it ignored, and then nobody could wait
  const Blocked blocked(awaited());
  const pid_t parent = getpid();
  for (;;) {
    board_.begin();
    const pid_t child = fork();
    if (child < 0) throw RunError(refused_start("process of the study", errno));
    if (child == 0) {
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      if (getppid() != parent) _exit(1);  // it had gone before that could be said
      return std::nullopt;
    }
    if (const std::optional<int> code = judge(wait_for(child))) return code;
  }
}

/// The wait status of the child, passing on what asks to end.
int Supervisor::wait_for(pid_t child) {
  const sigset_t set = awaited();
  overdue_.reset();
  double looked = clock_seconds(CLOCK_MONOTONIC);
  double not_before = 0;
  for (;;) {
    const timespec pause{0, 200'000'000};
    const int number = sigtimedwait(&set, nullptr, &pause);
    // Who was stopped with Ctrl-Z has stopped the runs too: their time begins anew.
    const double now = clock_seconds(CLOCK_MONOTONIC);
    if (now - looked > 5) not_before = now;
    looked = now;
    int status = 0;
    const pid_t ended = waitpid(child, &status, WNOHANG);
    if (ended < 0 && errno != EINTR) throw RunError(fmt::format("cannot wait for a process: {}", std::strerror(errno)));
    if (number > 0 && number != SIGCHLD) {
      if (!asked_to_end_) asked_to_end_ = now;
      // A terminal has sent it to both, so that twice at once says no more than once.
      insisted_ = now - *asked_to_end_ > 1;
      if (ended == 0) kill(child, insisted_ ? SIGKILL : number);
    }
    if (ended == child) return status;
    if (!overdue_) overdue_ = board_.overdue(not_before);
    if (overdue_) kill(child, SIGKILL);
  }
}

/// What became of a process; nothing where another one is to go on.
std::optional<int> Supervisor::judge(int status) {
  std::vector<RunPlace> places = board_.places();
  Ending ending;
  if (overdue_ && WIFSIGNALED(status)) {
    places = {*overdue_};
    ending = {took_longer(board_.timeout()), true};
  } else if (WIFSIGNALED(status)) {
    const int number = WTERMSIG(status);
    if (std::find(crash_signals.begin(), crash_signals.end(), number) == crash_signals.end()) return end_by(number);
    // What one thread did to itself comes before what another one added while the first was ending.
    ending = ending_by(board_.signal() != 0 ? board_.signal() : number);
  } else {
    // Who leaves in the middle of a run did not mean to: a library's `exit`, or a sanitizer's.
    if (places.empty()) return WEXITSTATUS(status);
    ending = board_.signal() != 0 ? ending_by(board_.signal())
                                  : Ending{fmt::format("ended with exit code {}", WEXITSTATUS(status))};
  }
  ++crashes_;
  clear_bar_line();
  const std::string kept = "; the runs that had finished are kept";
  if (asked_to_end_) {
    tell_note(
        (insisted_ ? "interrupted again, and killed" : "interrupted, and then the process crashed: " + ending.text) +
        kept);
    return 1;
  }
  if (places.empty() && !ending.may_differ) {
    tell_note("the process crashed outside of any run, so that it is not tried again: " + ending.text + kept);
    return 1;
  }
  learn(ending, places);
  if (crashes_in_vain_ < 3) return std::nullopt;
  tell_note("the process crashed three times without one more run: " + ending.text + kept);
  return 1;
}

/// Whether that place was the first of the process, alone, because a process had ended there before.
bool Supervisor::was_trial(RunPlace place) const {
  if (place.stage != RunStage::planning && board_.trial() != place.number) return false;
  // Of planning the first suspect is the first case.
  for (const RunPlace& suspect : suspects_) {
    if ((suspect.stage == RunStage::planning) != (place.stage == RunStage::planning)) continue;
    if (suspect.number == place.number) return true;
    if (place.stage == RunStage::planning && !lost_.contains(suspect)) return false;
  }
  return false;
}

void Supervisor::learn(Ending ending, std::vector<RunPlace> places) {
  std::sort(places.begin(), places.end());
  const bool is_last = places.size() == 1 && was_trial(places.front());
  const bool gained = is_last || board_.rows() > rows_;
  crashes_in_vain_ = gained ? 0 : crashes_in_vain_ + 1;
  rows_ = board_.rows();
  if (is_last) {
    lost_.emplace(places.front(), ending);
  } else {
    // Those of this crash before those that another one left.
    for (const RunPlace& place : places) std::erase(suspects_, place);
    suspects_.insert(suspects_.begin(), places.begin(), places.end());
  }
  last_ = Crash{std::move(ending), std::move(places), is_last};
}

}  // namespace tactor
