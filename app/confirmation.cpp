#include "app/confirmation.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include "app/interruption.hpp"

namespace tactor {

bool confirmed(const std::string& question, bool yes, const std::atomic<int>& interrupted, std::FILE* shown) {
  constexpr int look_ms = 50;
  // What was typed before the question was no answer to it.
  tcflush(STDIN_FILENO, TCIFLUSH);
  fmt::print(shown, "{} [y/N] ", question);
  std::fflush(shown);
  if (yes) {
    fmt::print(shown, "yes\n");
    return true;
  }
  std::string answer;
  // Not by the library's streams, which take a read up again that a signal has ended.
  for (char c = 0; c != '\n';) {
    pollfd input{STDIN_FILENO, POLLIN, 0};
    const int ready = poll(&input, 1, look_ms);
    if (interrupted != 0 || (ready > 0 && read(STDIN_FILENO, &c, 1) <= 0)) {
      fmt::print(shown, "\n");
      // Half a line may have been typed, which the shell would get.
      tcflush(STDIN_FILENO, TCIFLUSH);
      return false;
    }
    if (ready > 0 && c != '\n') answer += c;
  }
  return answer == "y" || answer == "Y" || answer == "yes";
}

Ask ask_without_dead_man(bool accepted) {
  if (accepted) return [](const std::string&) { return true; };
  if (isatty(STDIN_FILENO) != 1 || isatty(STDERR_FILENO) != 1) return {};
  return [](const std::string& question) { return confirmed(question, false, interruption, stderr); };
}

}  // namespace tactor
