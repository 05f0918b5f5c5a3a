// tactor-emulate-usb PROFILE [OPTIONS] -- COMMAND...: runs a command on a machine that has the device, in software.
#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstring>
#include <fstream>
#include <iostream>
#include <random>
#include <sstream>

#include "devices/hardware/profile_files.hpp"
#include "devices/usb/emulator/emulator.hpp"
#include "devices/usb/emulator/interposition.hpp"
#include "devices/usb/emulator/known_devices.hpp"
#include "devices/usb/usb_link.hpp"
#include "framework/core/check.hpp"
#include "framework/core/input_file.hpp"
#include "framework/core/installation.hpp"
#include "framework/core/shown_text.hpp"
#include "framework/core/temporary_folder.hpp"
#include "framework/yaml/file_finder.hpp"

namespace tactor {

namespace {

constexpr const char* device_path = "/dev/bus/usb/emulated";
constexpr const char* usage =
    "tactor-emulate-usb PROFILE [OPTIONS] -- COMMAND...\n"
    "Runs COMMAND with an emulated USB device: `falcon`, the name of a profile (polhem), or the path of one.\n"
    "  --fault KIND@WHEN   something goes wrong; again and again, each after the one before. WHEN is SECONDS since "
    "the\n"
    "                      device was opened, driven+SECONDS since it has been driven, or +SECONDS since the last\n"
    "                      fault. KIND is one of unplug, replug, silent, short, long, empty, jump, stuck, status,\n"
    "                      garbage, unhomed, well (an end to all of them)\n"
    "  --script FILE       the same, one KIND@WHEN a line\n"
    "  --control FILE      a FIFO, made where there is none; a KIND written to it as a line happens at once\n"
    "  --hand FILE         the path of the hand: CSV of t, x, y, z in s and m in the device's base\n"
    "  --trace FILE        what the device does, as CSV\n"
    "  --uncalibrated      a device whose counters have no zero\n"
    "  --firmware          a Falcon that has its firmware and has found its zero\n"
    "  --wrong-device      another device under the same numbers\n";

struct Options {
  std::string profile, trace, control, hand;
  std::vector<FaultOrder> faults;
  bool uncalibrated = false, firmware = false, wrong_device = false, help = false;
  std::vector<char*> command;
};

constexpr std::uint64_t most_bytes = std::uint64_t{1} << 26U;  // of a script or a path

void add_fault(Options& options, const std::string& where, const std::string& text) {
  options.faults.push_back(read_fault_order(where, text));
}

void read_script(Options& options, const std::string& file) {
  std::istringstream in(read_input_file(file, most_bytes));
  int number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    if (!line.empty() && line.front() != '#') add_fault(options, file + ":" + std::to_string(number) + ":1", line);
  }
}

Options parse(int argc, char** argv) {
  Options options;
  int i = 1;
  const auto value = [&](const std::string& name) {
    if (i + 1 >= argc || std::strcmp(argv[i + 1], "--") == 0) throw InputError(name + ": expected a value");
    return std::string(argv[++i]);
  };
  for (; i < argc && std::strcmp(argv[i], "--") != 0; ++i) {
    const std::string word = argv[i];
    if (word == "--help" || word == "-h")
      options.help = true;
    else if (word == "--fault")
      add_fault(options, word, value(word));
    else if (word == "--script")
      read_script(options, value(word));
    else if (word == "--control")
      options.control = value(word);
    else if (word == "--hand")
      options.hand = value(word);
    else if (word == "--trace")
      options.trace = value(word);
    else if (word == "--uncalibrated")
      options.uncalibrated = true;
    else if (word == "--firmware")
      options.firmware = true;
    else if (word == "--wrong-device")
      options.wrong_device = true;
    else if (word.starts_with("-") || !options.profile.empty())
      throw InputError("unknown argument " + word + "\n" + usage);
    else
      options.profile = word;
  }
  for (++i; i < argc; ++i) options.command.push_back(argv[i]);
  if (options.help) return options;
  if (options.profile.empty()) throw InputError(std::string("expected the name of a profile\n") + usage);
  if (options.command.empty()) throw InputError(std::string("expected -- and a command\n") + usage);
  return options;
}

/// The hand's path from a CSV of t, x, y, z, with or without a heading.
void read_hand(const std::string& file, HandModel& hand) {
  std::istringstream in(read_input_file(file, most_bytes));
  hand.times.clear();
  hand.points.clear();
  int number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    for (char& c : line) c = c == ',' ? ' ' : c;
    std::istringstream row(line);
    double t = 0;
    Vec3 p;
    if (row >> t >> p.x >> p.y >> p.z) {
      if (!hand.times.empty() && t <= hand.times.back()) {
        throw InputError(file + ":" + std::to_string(number) + ":1: expected a time after the one before");
      }
      hand.times.push_back(t);
      hand.points.push_back(p);
    } else if (number > 1 && !line.empty()) {
      throw InputError(file + ":" + std::to_string(number) + ":1: expected t, x, y, z");
    }
  }
  if (hand.times.empty()) throw InputError("--hand " + file + ": expected lines of t, x, y, z, found none");
}

/// The library that is loaded in front of the C library: beside the nodes.
std::string preload_file() {
  const std::filesystem::path file = library_folder() / "tactor" / "tactor-usb-preload.so";
  // The loader takes these for the end of a name.
  if (file.string().find_first_of(" \t:;") != std::string::npos) {
    throw InputError(file.string() + ": expected a folder without blanks, : and ;, which LD_PRELOAD cannot name");
  }
  if (std::filesystem::exists(file)) return file.string();
  throw InputError(file.string() + " is missing; build or install tactor again");
}

/// Does as a person would who puts the handle into its pose and calibrates, through libusb and all.
void calibrate(const UsbProfile& profile, const Emulation& emulation) {
  Emulation quiet = emulation;
  quiet.faults.clear();
  quiet.trace.clear();
  quiet.control.clear();
  quiet.hand.hold = 1e6;
  UsbEmulator emulator(quiet);
  interpose(emulator.node());
  emulator.run();
  UsbLink(profile, {"", emulation.path}).calibrate(Duration{20'000'000});
  withdraw(emulator.node());
}

pid_t child = -1;

/// Runs the command to its end and returns its exit code, as a shell would.
int run(const std::vector<char*>& command) {
  std::vector<char*> arguments = command;
  arguments.push_back(nullptr);
  // The terminal's Ctrl-C reaches the command too; what is sent to this process alone is passed on.
  signal(SIGINT, SIG_IGN);
  child = fork();
  if (child < 0) throw RunError(std::string("cannot start ") + command[0] + ": " + std::strerror(errno));
  if (child == 0) {
    signal(SIGINT, SIG_DFL);
    execvp(arguments[0], arguments.data());
    std::fprintf(stderr, "tactor-emulate-usb: %s: %s\n", arguments[0], std::strerror(errno));
    _exit(127);
  }
  for (const int number : {SIGTERM, SIGHUP}) {
    signal(number, [](int n) { kill(child, n); });
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

void put_in_front(const char* name, const std::string& value) {
  const char* old = std::getenv(name);
  const std::string all = old == nullptr || *old == '\0' ? value : value + ":" + old;
  setenv(name, all.c_str(), 1);
}

int emulate(int argc, char** argv) {
  const Options options = parse(argc, argv);
  if (options.help) {
    std::cout << usage;
    return 0;
  }
  const bool is_falcon = options.profile == "falcon";
  UsbProfile profile;
  if (!is_falcon) profile = read_usb_profile(named_file(options.profile, profiles_of("usb")));
  Emulation emulation = is_falcon ? falcon_emulation() : emulation_of(profile);
  if (!options.hand.empty()) read_hand(options.hand, emulation.hand);
  const TemporaryFolder folder;
  emulation.path = device_path;
  emulation.serial = "emulated-" + std::to_string(std::random_device{}());
  emulation.state = (folder.path() / "state").string();
  emulation.faults = options.faults;
  if (!options.trace.empty()) {
    emulation.trace = std::filesystem::absolute(options.trace).string();
    if (!std::ofstream(emulation.trace)) throw InputError("--trace " + options.trace + ": cannot be written");
  }
  if (!options.control.empty()) {
    emulation.control = std::filesystem::absolute(options.control).string();
    if (mkfifo(emulation.control.c_str(), 0600) != 0 && errno != EEXIST) {
      throw InputError("--control " + options.control + ": cannot be made: " + std::strerror(errno));
    }
    if (!std::filesystem::is_fifo(emulation.control)) {
      throw InputError("--control " + options.control +
                       ": expected a name that is free, or a FIFO, found another kind of file; choose another name");
    }
  }
  if (options.wrong_device) emulation.bulk = !emulation.bulk;
  if (options.firmware) {
    const auto state = map_state(emulation.state);
    state->firmware = 1;
    state->homed = 7;
  }
  const std::string preload = preload_file();
  if (!is_falcon && !profile.calibration.empty() && !options.uncalibrated && !options.wrong_device) {
    calibrate(profile, emulation);
  }
  const std::string description = (folder.path() / "device").string();
  std::ofstream(description) << to_text(emulation);
  setenv("TACTOR_EMULATED_USB", description.c_str(), 1);
  setenv("TACTOR_USB_FILE", device_path, 1);
  put_in_front("LD_PRELOAD", preload);
#ifdef __SANITIZE_ADDRESS__
  // The sanitizer's library comes behind ours then, which it refuses unless it is told not to look.
  put_in_front("ASAN_OPTIONS", "verify_asan_link_order=0");
#endif
  return run(options.command);
}

}  // namespace

}  // namespace tactor

int main(int argc, char** argv) {
  tactor::show_only_text();
  try {
    return tactor::emulate(argc, argv);
  } catch (const tactor::InputError& error) {
    std::cerr << error.what() << '\n';
    return 2;
  } catch (const std::exception& error) {
    std::cerr << "tactor-emulate-usb: " << error.what() << '\n';
    return 1;
  }
}
