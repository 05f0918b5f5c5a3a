// Runs another command, without a shell between, and reads what it prints.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace tactor {

/// How a command came to its end.
enum class CommandEnd : std::uint8_t {
  exited,       ///< by itself; `code` is its exit code
  killed,       ///< by a signal, `code`
  not_there,    ///< there is no such program
  not_started,  ///< the system refused, `code` is its errno
  too_slow,     ///< it took longer than it may, and was ended
  too_much,     ///< it printed more than it may, and was ended
  interrupted,  ///< somebody asked this program to end, which ended it
};

struct CommandRequest {
  std::vector<std::string> words;  ///< the program, looked for in PATH, and its arguments as they are
  std::string input;               ///< what it reads from standard input
  /// Its environment as `NAME=value`; absent: that of this process.
  std::optional<std::vector<std::string>> environment;
  std::optional<std::chrono::seconds> longest;                       ///< what it may take; absent: as long as it likes
  std::size_t most_bytes = std::numeric_limits<std::size_t>::max();  ///< that it may print, on each of its outputs
};

struct CommandResult {
  CommandEnd end = CommandEnd::not_started;
  int code = 0;
  std::string out, err;  ///< what it has printed to standard output and standard error
  [[nodiscard]] bool is_good() const { return end == CommandEnd::exited && code == 0; }
};

/// Runs a command until it ends and nothing has its outputs open any more. The command gets no file of this process.
/// SIGINT and SIGTERM end it. Throws RunError where this process has no room for its files.
CommandResult run_command(const CommandRequest& request);

/// Why it did not end well, such as `has failed: no such file`; to be put behind the name of the command.
std::string failure_of(const CommandResult& result);

/// What a command printed that reads `input`. Throws RunError where it cannot be started, or ends with another code
/// than 0: with what it wrote to standard error.
std::string output_of(const std::vector<std::string>& words, const std::string& input = {});

/// The variables that a program of others is to find, as `NAME=value`: those of this process, with the caller's
/// LD_LIBRARY_PATH where we are in a bundle, whose libraries are not for programs of others.
std::vector<std::string> environment_for_others();

}  // namespace tactor
