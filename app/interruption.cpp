#include "app/interruption.hpp"

#include <csignal>

namespace tactor {

std::atomic<int> interruption = 0;

namespace {
void interrupt(int /*number*/) {
  ++interruption;
}
}  // namespace

void listen_for_interruption() {
  std::signal(SIGINT, interrupt);
  std::signal(SIGTERM, interrupt);
  // The terminal has been closed; nohup says that this is no reason to end.
  if (std::signal(SIGHUP, interrupt) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);
  // A file that may not grow any more is an error that the run can answer, with a ramp to zero, like a full disk.
  std::signal(SIGXFSZ, SIG_IGN);
}

void end_instead_of_stopping() {
  for (const int number : {SIGTSTP, SIGQUIT}) std::signal(number, interrupt);
  for (const int number : {SIGTTOU, SIGTTIN}) std::signal(number, SIG_IGN);
}

}  // namespace tactor
