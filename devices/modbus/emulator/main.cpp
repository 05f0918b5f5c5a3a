// The program behind `tactor emulate modbus`: an emulated Modbus actuator on TCP or a pseudo-terminal.
#include <poll.h>
#include <unistd.h>

#include <charconv>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <string>
#include <vector>

#include "devices/hardware/profile_files.hpp"
#include "devices/modbus/emulator/server.hpp"
#include "framework/core/check.hpp"
#include "framework/core/shown_text.hpp"
#include "framework/yaml/file_finder.hpp"

using namespace tactor;
using namespace tactor::modbus;

namespace {

volatile std::sig_atomic_t asked_to_end = 0;
constexpr std::size_t longest_order = 4096;

constexpr const char* usage =
    "tactor emulate modbus PROFILE --tcp PORT | --pty [options]\n\n"
    "Serves an emulated actuator with the registers of PROFILE (a file, or a name such as modbus/iris_orca.yaml), and "
    "says\n"
    "where: `ready tcp:127.0.0.1:PORT` or `ready rtu:/dev/pts/N`, which is what `connect` of a graph takes.\n\n"
    "  --tcp PORT       on 127.0.0.1; 0 takes a free port\n"
    "  --pty            on a pseudo-terminal, with the time that a serial line of the profile's baud rate takes\n"
    "  --baud N         that baud rate instead\n"
    "  --no-line-delay  a pseudo-terminal without that time\n"
    "  --link PATH      a symbolic link to the pseudo-terminal\n"
    "  --fault F        KIND[@TIME or @driven+TIME][:VALUE], any number of times: silent, slow, dribble, late, crc, "
    "slave,\n"
    "                   length, exception, reset, another, jump, stuck, unplug, status; TIME in s from the first "
    "request, or\n"
    "                   of an unbroken force; VALUE in s, m or the bit\n"
    "  --log FILE       writes time in ns, position, force, commanded force, watchdog, commands so far and net energy\n"
    "                   that the motors gave in J, every 2 ms\n\n"
    "On standard input `fault F` injects one at once, `clear` ends those that go on, `quit` ends. In the background of "
    "a\n"
    "terminal it reads nothing.\n";

struct Arguments {
  std::string profile;
  EmulatorOptions options;
  bool has_line = false;
  int baud = 0;
};

int whole(const std::string& option, const std::string& text, int min, int max) {
  int value = 0;
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  if (result.ec == std::errc{} && result.ptr == text.data() + text.size() && value >= min && value <= max) return value;
  throw InputError(option + ": expected a whole number from " + std::to_string(min) + " to " + std::to_string(max) +
                   ", found \"" + text + "\"");
}

Arguments parse(const std::vector<std::string>& words) {
  Arguments a;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& word = words[i];
    const auto value = [&]() -> const std::string& {
      if (i + 1 >= words.size()) throw InputError(word + ": expected a value after it");
      return words[++i];
    };
    if (word == "--tcp") {
      a.options.port = whole(word, value(), 0, 65535);
      if (a.has_line) throw InputError("expected one of --tcp and --pty, found both");
      a.has_line = true;
    } else if (word == "--pty") {
      if (a.has_line) throw InputError("expected one of --tcp and --pty, found both");
      a.has_line = a.options.serial = true;
    } else if (word == "--baud") {
      a.baud = whole(word, value(), 1200, 4'000'000);
    } else if (word == "--no-line-delay") {
      a.options.line_delay = false;
    } else if (word == "--link") {
      a.options.link = value();
    } else if (word == "--fault") {
      a.options.faults.push_back(parse_fault(value()));
    } else if (word == "--log") {
      a.options.log = value();
    } else if (word.starts_with("-")) {
      throw InputError("unknown option " + word + "\n\n" + usage);
    } else if (a.profile.empty()) {
      a.profile = word;
    } else {
      throw InputError("expected one profile, found " + a.profile + " and " + word);
    }
  }
  if (a.profile.empty() || !a.has_line) throw InputError(std::string("expected a profile and a line\n\n") + usage);
  return a;
}

bool obey(Emulator& emulator, const std::string& line) {
  if (line == "quit") return false;
  if (line == "clear") {
    emulator.end_all_faults();
    std::printf("cleared\n");
    std::fflush(stdout);
  }
  if (line.starts_with("fault ")) {
    try {
      emulator.inject(parse_fault(line.substr(6)));
      std::printf("injected %s\n", line.substr(6).c_str());
    } catch (const InputError& error) {
      std::printf("%s\n", error.what());
    }
    std::fflush(stdout);
  }
  return true;
}

/// Whether what is typed at the terminal is meant for this program. A file or a pipe always is.
bool in_foreground() {
  const pid_t foreground = tcgetpgrp(STDIN_FILENO);
  return foreground < 0 || foreground == getpgrp();
}

void attend(Emulator& emulator) {
  std::string pending;
  bool listens = true;
  while (asked_to_end == 0) {
    pollfd input{listens && in_foreground() ? STDIN_FILENO : -1, POLLIN, 0};
    if (poll(&input, 1, 50) <= 0 || input.revents == 0) continue;
    char buffer[256];
    const ssize_t n = read(STDIN_FILENO, buffer, sizeof buffer);
    // It has just been sent to the background.
    if (n < 0 && !in_foreground()) continue;
    if (n <= 0) {
      // Nobody will say more; it serves until it is ended.
      listens = false;
      continue;
    }
    pending.append(buffer, static_cast<std::size_t>(n));
    // Longer than every order: nobody ends that line, and it must not fill the memory.
    if (pending.size() > longest_order && pending.find('\n') == std::string::npos) pending.clear();
    for (std::size_t end = 0; (end = pending.find('\n')) != std::string::npos; pending.erase(0, end + 1)) {
      if (!obey(emulator, pending.substr(0, end))) return;
    }
  }
}

int run(const std::vector<std::string>& words) {
  for (const std::string& word : words) {
    if (word == "--help" || word == "-h") {
      std::fputs(usage, stdout);
      return 0;
    }
  }
  Arguments a = parse(words);
  if (!a.options.link.empty() && !a.options.serial) throw InputError("--link: expected --pty with it");
  Profile profile = read_profile(named_file(a.profile, profiles_of("modbus")));
  if (a.baud > 0) profile.line.baud = a.baud;
  Emulator emulator(std::move(profile), a.options);
  emulator.start();
  std::printf("ready %s\n", emulator.address().c_str());
  std::fflush(stdout);
  attend(emulator);
  emulator.stop();
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  tactor::show_only_text();
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) std::signal(number, [](int) { asked_to_end = 1; });
  // In the background of a terminal it goes on serving, whatever is typed there, and may still say something.
  for (const int number : {SIGPIPE, SIGTTIN, SIGTTOU}) std::signal(number, SIG_IGN);
  try {
    return run({argv + 1, argv + argc});
  } catch (const InputError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "tactor-emulate-modbus: %s\n", error.what());
    return 1;
  }
}
