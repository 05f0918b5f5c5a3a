#include "app/interruption.hpp"

#include <csignal>
#include <cstdint>

namespace tactor {

std::atomic<int> interruption = 0;

namespace {

/// What a signal does to a run that drives devices.
enum class Meaning : std::uint8_t {
  ends,          ///< counts in `interruption`: the run ramps down and ends
  ends_if_sent,  ///< the same where a process sent it; it ends a program that has crashed, as ever
  fails,         ///< the call that caused it fails, and whoever made the call says so
  ignored,       ///< a terminal would stop the program on the spot
};

/// Signals from one number to another.
struct SignalRow {
  int first, last;
  Meaning meaning;
};

/// Heard by every verb, even where the shell has told a command in the background to ignore them.
constexpr int asked_by_hand[]{SIGINT, SIGTERM};

/// Every other signal that would end or stop the program and that a program can handle. SIGKILL and SIGSTOP are those
/// that none can.
const SignalRow while_live[]{
    {SIGHUP, SIGHUP, Meaning::ends},           {SIGQUIT, SIGQUIT, Meaning::ends},
    {SIGUSR1, SIGUSR1, Meaning::ends},         {SIGUSR2, SIGUSR2, Meaning::ends},
    {SIGALRM, SIGALRM, Meaning::ends},         {SIGVTALRM, SIGVTALRM, Meaning::ends},
    {SIGPROF, SIGPROF, Meaning::ends},         {SIGPOLL, SIGPOLL, Meaning::ends},
    {SIGPWR, SIGPWR, Meaning::ends},           {SIGSTKFLT, SIGSTKFLT, Meaning::ends},
    {SIGXCPU, SIGXCPU, Meaning::ends},         {SIGTSTP, SIGTSTP, Meaning::ends},
    {SIGRTMIN, SIGRTMAX, Meaning::ends},       {SIGSEGV, SIGSEGV, Meaning::ends_if_sent},
    {SIGABRT, SIGABRT, Meaning::ends_if_sent}, {SIGBUS, SIGBUS, Meaning::ends_if_sent},
    {SIGFPE, SIGFPE, Meaning::ends_if_sent},   {SIGILL, SIGILL, Meaning::ends_if_sent},
    {SIGTRAP, SIGTRAP, Meaning::ends_if_sent}, {SIGSYS, SIGSYS, Meaning::ends_if_sent},
    {SIGPIPE, SIGPIPE, Meaning::fails},        {SIGXFSZ, SIGXFSZ, Meaning::fails},
    {SIGTTOU, SIGTTOU, Meaning::ignored},      {SIGTTIN, SIGTTIN, Meaning::ignored},
};

std::atomic<int> asked_last = SIGTERM;

void interrupt(int number) {
  asked_last = number;
  ++interruption;
}

/// kill and sigqueue send; a crash comes from the kernel, and abort and raise come by tgkill.
void interrupt_if_sent(int number, siginfo_t* info, void* /*context*/) {
  if (info->si_code == SI_USER || info->si_code == SI_QUEUE) {
    ++interruption;
    return;
  }
  std::signal(number, SIG_DFL);
  raise(number);  // delivered when this handler returns
}

void let_the_call_fail(int /*number*/) {}

/// Gives the signal its meaning. What somebody else has it handled or ignored by (nohup, a sanitizer) stays.
void give(int number, Meaning meaning) {
  struct sigaction action {};
  if (sigaction(number, nullptr, &action) != 0 || (action.sa_flags & SA_SIGINFO) != 0) return;
  if (action.sa_handler != SIG_DFL) return;
  action = {};
  action.sa_flags = SA_RESTART;
  switch (meaning) {
    case Meaning::ends:
      action.sa_handler = interrupt;
      break;
    case Meaning::ends_if_sent:
      action.sa_flags |= SA_SIGINFO;
      action.sa_sigaction = interrupt_if_sent;
      break;
    case Meaning::fails:
      // Not SIG_IGN, which programs that are started from here would inherit.
      action.sa_handler = let_the_call_fail;
      break;
    case Meaning::ignored:
      action.sa_handler = SIG_IGN;
      break;
  }
  sigaction(number, &action, nullptr);
}

}  // namespace

void listen_for_interruption() {
  for (const int number : asked_by_hand) std::signal(number, interrupt);
  // The terminal has been closed.
  give(SIGHUP, Meaning::ends);
  // A file that may not grow any more is an error that every verb can answer, like a full disk.
  give(SIGXFSZ, Meaning::fails);
}

void stop_listening_for_interruption() {
  struct sigaction action {};
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
    if (sigaction(number, nullptr, &action) == 0 && action.sa_handler == interrupt) std::signal(number, SIG_DFL);
  }
  if (is_interrupted()) raise(asked_last);
}

void ramp_down_on_signals() {
  for (const SignalRow& row : while_live) {
    for (int number = row.first; number <= row.last; ++number) give(number, row.meaning);
  }
}

}  // namespace tactor
