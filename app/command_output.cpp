#include "app/command_output.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <string_view>

#include "app/interruption.hpp"
#include "framework/core/check.hpp"
#include "framework/core/file_descriptor.hpp"
#include "framework/core/text.hpp"

namespace tactor {

namespace {

using CommandClock = std::chrono::steady_clock;
constexpr std::chrono::milliseconds command_look_period{50};  // at what may end a command early
constexpr std::chrono::seconds command_grace{2};              // from the request to end to the kill

struct OutputPipe {
  FileDescriptor read, write;
};

OutputPipe make_pipe() {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) throw RunError(fmt::format("no pipe: {}", std::strerror(errno)));
  return {FileDescriptor(ends[0]), FileDescriptor(ends[1])};
}

/// A file without a name: unlike a pipe it cannot fill up, and whoever reads it may stop early.
FileDescriptor file_with(const std::string& bytes) {
  FileDescriptor file(memfd_create("tactor", MFD_CLOEXEC));
  if (!file || !file.write_all(bytes.data(), bytes.size()) || lseek(file.number(), 0, SEEK_SET) != 0) {
    throw RunError(fmt::format("no room for what another command is to read: {}", std::strerror(errno)));
  }
  return file;
}

class Attributes {
 public:
  /// In a group of its own what the command has started can be ended with it.
  explicit Attributes(bool own_group) {
    posix_spawnattr_init(&attributes_);
    // What this process has ignored is no business of others: a pipe of theirs would never end.
    sigset_t usual{}, none{};
    sigemptyset(&usual);
    sigemptyset(&none);
    sigaddset(&usual, SIGPIPE);
    sigaddset(&usual, SIGXFSZ);
    posix_spawnattr_setsigdefault(&attributes_, &usual);
    posix_spawnattr_setsigmask(&attributes_, &none);
    const int flags = POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETSIGMASK | (own_group ? POSIX_SPAWN_SETPGROUP : 0);
    posix_spawnattr_setflags(&attributes_, static_cast<short>(flags));
  }
  ~Attributes() { posix_spawnattr_destroy(&attributes_); }
  Attributes(const Attributes&) = delete;
  Attributes& operator=(const Attributes&) = delete;
  [[nodiscard]] const posix_spawnattr_t* get() const { return &attributes_; }

 private:
  posix_spawnattr_t attributes_{};
};

std::vector<char*> pointers_to(std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  for (std::string& text : texts) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  return pointers;
}

/// A command that runs, until it is waited for.
class Running {
 public:
  Running(const CommandRequest& request, CommandResult& result)
      : request_(request), result_(result), has_group_(request.longest.has_value()) {}

  /// False, with the reason in the result, where it does not start.
  bool start() {
    OutputPipe out = make_pipe(), err = make_pipe();
    const FileDescriptor input = request_.input.empty() ? FileDescriptor() : file_with(request_.input);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    if (input) posix_spawn_file_actions_adddup2(&actions, input.number(), STDIN_FILENO);
    if (!input) posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&actions, out.write.number(), STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions, err.write.number(), STDERR_FILENO);
    posix_spawn_file_actions_addclosefrom_np(&actions, STDERR_FILENO + 1);
    std::vector<std::string> words = request_.words;
    std::vector<std::string> environment = request_.environment.value_or(environment_for_others());
    const Attributes attributes(has_group_);
    const int error = posix_spawnp(&process_, words.front().c_str(), &actions, attributes.get(),
                                   pointers_to(words).data(), pointers_to(environment).data());
    posix_spawn_file_actions_destroy(&actions);
    if (error != 0) {
      result_.end = error == ENOENT ? CommandEnd::not_there : CommandEnd::not_started;
      result_.code = error;
      return false;
    }
    pipes_ = {std::move(out.read), std::move(err.read)};
    return true;
  }

  void finish() {
    while (is_open(0) || is_open(1)) {
      if (!go_on()) return;
      std::array<pollfd, 2> polled{{{number(0), POLLIN, 0}, {number(1), POLLIN, 0}}};
      if (poll(polled.data(), polled.size(), static_cast<int>(command_look_period.count())) <= 0) continue;
      for (std::size_t i = 0; i < polled.size(); ++i) {
        if (polled[i].revents != 0) read_some(i);
      }
    }
    int status = 0;
    for (pid_t ended = 0; (ended = waitpid(process_, &status, WNOHANG)) != process_;) {
      if (ended < 0 && errno != EINTR)
        throw RunError(fmt::format("cannot wait for {}: {}", request_.words.front(), std::strerror(errno)));
      if (!go_on()) return;
      poll(nullptr, 0, 5);
    }
    result_.end = WIFEXITED(status) ? CommandEnd::exited : CommandEnd::killed;
    result_.code = WIFEXITED(status) ? WEXITSTATUS(status) : WTERMSIG(status);
  }

 private:
  [[nodiscard]] int number(std::size_t pipe) const { return pipes_.at(pipe).number(); }
  [[nodiscard]] bool is_open(std::size_t pipe) const { return number(pipe) >= 0; }

  void read_some(std::size_t pipe) {
    std::array<char, 4096> part{};
    const ssize_t got = ::read(number(pipe), part.data(), part.size());
    if (got < 0 && errno == EINTR) return;
    if (got <= 0) {
      static_cast<void>(pipes_.at(pipe).close());
      return;
    }
    std::string& to = pipe == 0 ? result_.out : result_.err;
    to.append(part.data(), static_cast<std::size_t>(got));
    is_too_long_ = is_too_long_ || to.size() > request_.most_bytes;
  }

  /// Ends the command where it may not go on, and is then false.
  bool go_on() {
    const bool asked = interruption.load() != interrupted_before_;
    const bool slow = request_.longest && CommandClock::now() - began_ > *request_.longest;
    if (!asked && !slow && !is_too_long_) return true;
    end();
    result_.end = asked ? CommandEnd::interrupted : is_too_long_ ? CommandEnd::too_much : CommandEnd::too_slow;
    return false;
  }

  void end() const {
    const pid_t whom = has_group_ ? -process_ : process_;
    kill(whom, SIGTERM);
    const auto until = CommandClock::now() + command_grace;
    while (waitpid(process_, nullptr, WNOHANG) == 0) {
      if (CommandClock::now() > until) {
        kill(whom, SIGKILL);
        while (waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
        }
        return;
      }
      poll(nullptr, 0, 10);
    }
    if (has_group_) kill(whom, SIGKILL);  // what it has left behind
  }

  const CommandRequest& request_;
  CommandResult& result_;
  bool has_group_;
  pid_t process_ = 0;
  std::array<FileDescriptor, 2> pipes_;
  bool is_too_long_ = false;
  // A command that cleans up after an interruption is ended by the next one.
  int interrupted_before_ = interruption.load();
  CommandClock::time_point began_ = CommandClock::now();
};

}  // namespace

std::vector<std::string> environment_for_others() {
  constexpr std::string_view own = "LD_LIBRARY_PATH=", outer = "TACTOR_OUTER_LD_LIBRARY_PATH=";
  const char* callers = std::getenv("TACTOR_OUTER_LD_LIBRARY_PATH");
  std::vector<std::string> entries;
  for (char** variable = environ; *variable != nullptr; ++variable) {
    const std::string_view entry = *variable;
    if (entry.starts_with(outer) || (callers != nullptr && entry.starts_with(own))) continue;
    entries.emplace_back(entry);
  }
  if (callers != nullptr && *callers != '\0') entries.push_back(std::string(own) + callers);
  return entries;
}

CommandResult run_command(const CommandRequest& request) {
  std::signal(SIGCHLD, SIG_DFL);  // who started us may have it ignored, and then nobody could wait
  CommandResult result;
  Running running(request, result);
  if (running.start()) running.finish();
  return result;
}

std::string failure_of(const CommandResult& result) {
  const std::string said(trimmed(result.err));
  const std::string words = said.empty() ? std::string("it says nothing") : said;
  switch (result.end) {
    case CommandEnd::exited:
      return fmt::format("has failed: {}", words);
    case CommandEnd::killed:
      return fmt::format("was ended by signal {}: {}", result.code, words);
    case CommandEnd::not_there:
      return fmt::format("cannot be started: {}; is it installed here?", std::strerror(result.code));
    case CommandEnd::not_started:
      return fmt::format("cannot be started: {}", std::strerror(result.code));
    case CommandEnd::too_slow:
      return "took too long and was ended";
    case CommandEnd::too_much:
      return "printed too much and was ended";
    case CommandEnd::interrupted:
      return "was interrupted";
  }
  TACTOR_DEMAND(false);
}

std::string output_of(const std::vector<std::string>& words, const std::string& input) {
  CommandResult result = run_command({.words = words, .input = input});
  if (!result.is_good()) throw RunError(fmt::format("{} {}", fmt::join(words, " "), failure_of(result)));
  return std::move(result.out);
}

}  // namespace tactor
