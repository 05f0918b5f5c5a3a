#include "app/command_output.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <string_view>

#include "framework/core/check.hpp"
#include "framework/core/file_descriptor.hpp"
#include "framework/core/text.hpp"

namespace tactor {

namespace {

/// Reads both pipes of a command to their ends; what comes on the second goes to `errors`.
std::string read_pipes(const FileDescriptor& out, const FileDescriptor& err, std::string& errors) {
  std::string text;
  std::array<pollfd, 2> pipes{{{out.number(), POLLIN, 0}, {err.number(), POLLIN, 0}}};
  const std::array<std::string*, 2> to{&text, &errors};
  std::array<char, 4096> part{};
  while (pipes[0].fd >= 0 || pipes[1].fd >= 0) {
    if (poll(pipes.data(), pipes.size(), -1) < 0) continue;
    for (std::size_t i = 0; i < pipes.size(); ++i) {
      if (pipes[i].fd < 0 || pipes[i].revents == 0) continue;
      const ssize_t got = ::read(pipes[i].fd, part.data(), part.size());
      if (got > 0) to[i]->append(part.data(), static_cast<std::size_t>(got));
      if (got == 0 || (got < 0 && errno != EINTR)) pipes[i].fd = -1;
    }
  }
  return text;
}

/// The environment of this process, with the caller's LD_LIBRARY_PATH where we are in a bundle, whose libraries are not
/// for programs of others.
class Environment {
 public:
  Environment() {
    constexpr std::string_view own = "LD_LIBRARY_PATH=", outer = "TACTOR_OUTER_LD_LIBRARY_PATH=";
    const char* callers = std::getenv("TACTOR_OUTER_LD_LIBRARY_PATH");
    for (char** variable = environ; *variable != nullptr; ++variable) {
      const std::string_view entry = *variable;
      if (entry.starts_with(outer) || (callers != nullptr && entry.starts_with(own))) continue;
      entries_.emplace_back(entry);
    }
    if (callers != nullptr && *callers != '\0') entries_.push_back(std::string(own) + callers);
    for (std::string& entry : entries_) pointers_.push_back(entry.data());
    pointers_.push_back(nullptr);
  }
  [[nodiscard]] char* const* pointers() const { return pointers_.data(); }

 private:
  std::vector<std::string> entries_;
  std::vector<char*> pointers_;
};

}  // namespace

std::string output_of(const std::vector<std::string>& words) {
  std::signal(SIGCHLD, SIG_DFL);  // who started us may have it ignored, and then nobody could wait
  std::array<int, 2> out{}, err{};
  if (pipe2(out.data(), O_CLOEXEC) != 0) throw RunError(fmt::format("no pipe: {}", std::strerror(errno)));
  const FileDescriptor out_read(out[0]);
  FileDescriptor out_write(out[1]);
  if (pipe2(err.data(), O_CLOEXEC) != 0) throw RunError(fmt::format("no pipe: {}", std::strerror(errno)));
  const FileDescriptor err_read(err[0]);
  FileDescriptor err_write(err[1]);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, out_write.number(), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, err_write.number(), STDERR_FILENO);
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  pid_t process = 0;
  Environment environment;
  const int error =
      posix_spawnp(&process, words.front().c_str(), &actions, nullptr, arguments.data(), environment.pointers());
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) {
    throw RunError(fmt::format("cannot start {}: {}; is it installed here?", words.front(), std::strerror(error)));
  }
  static_cast<void>(out_write.close());
  static_cast<void>(err_write.close());
  std::string errors;
  std::string text = read_pipes(out_read, err_read, errors);
  int status = 0;
  while (waitpid(process, &status, 0) < 0) {
    if (errno != EINTR) throw RunError(fmt::format("cannot wait for {}: {}", words.front(), std::strerror(errno)));
  }
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    throw RunError(fmt::format("{} has failed: {}", fmt::join(words, " "),
                               errors.empty() ? std::string("it says nothing") : std::string(trimmed(errors))));
  }
  return text;
}

}  // namespace tactor
