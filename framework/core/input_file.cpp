#include "framework/core/input_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>

namespace tactor {

namespace fs = std::filesystem;

namespace {

/// What stands at a path that is no regular file, with what to do.
std::string kind_of(mode_t mode) {
  const std::string remedy = "; write its content to a file and name that";
  if (S_ISDIR(mode)) return "a folder";
  if (S_ISFIFO(mode)) return "a pipe" + remedy;
  if (S_ISSOCK(mode)) return "a socket" + remedy;
  if (S_ISCHR(mode) || S_ISBLK(mode)) return "a device" + remedy;
  return "something else";
}

/// The log that keeps what is opened; usually none.
InputLog* open_log = nullptr;

}  // namespace

InputLog::InputLog() {
  TACTOR_DEMAND(open_log == nullptr);
  open_log = this;
}

InputLog::~InputLog() {
  open_log = nullptr;
}

InputFile open_input(const fs::path& path) {
  InputFile input;
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) {
    input.is_missing = errno == ENOENT || errno == ENOTDIR;
    input.error = input.is_missing ? "there is no such file" : std::string("cannot be read: ") + std::strerror(errno);
    return input;
  }
  if (S_ISREG(status.st_mode)) {
    // O_NONBLOCK and the second look: the file may have been replaced since.
    input.file = FileDescriptor(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC));
    if (!input.file || ::fstat(input.file.number(), &status) != 0) {
      input.file = {};
      input.error = std::string("cannot be read: ") + std::strerror(errno);
      return input;
    }
    if (open_log != nullptr) open_log->files_.insert(fs::weakly_canonical(path));
  }
  if (!S_ISREG(status.st_mode)) {
    input.file = {};
    input.found = kind_of(status.st_mode);
    input.error = "expected a file, found " + input.found;
  }
  input.size = static_cast<std::uint64_t>(std::max<off_t>(status.st_size, 0));
  return input;
}

FileDescriptor open_input_file(const fs::path& path) {
  InputFile input = open_input(path);
  if (!input.file) throw InputError(path.string() + ": " + input.error);
  return std::move(input.file);
}

std::optional<std::size_t> InputFile::read_some(char* bytes, std::size_t most) {
  ssize_t n = -1;
  do {
    n = ::read(file.number(), bytes, most);
  } while (n < 0 && errno == EINTR);
  if (n >= 0) return static_cast<std::size_t>(n);
  error = std::string("cannot be read: ") + std::strerror(errno);
  return std::nullopt;
}

bool InputFile::read(std::string& bytes, std::uint64_t most) {
  const auto too_large = [&] {
    error = "expected at most " + std::to_string(most) + " bytes, found a larger file";
    return false;
  };
  if (size > most) return too_large();
  // Files of the kernel show no size, so the end of the file counts. One byte more finds it without growing.
  bytes.assign(size + 1, '\0');
  std::size_t got = 0;
  while (true) {
    if (got > most) return too_large();
    if (got == bytes.size()) {
      bytes.resize(got + std::min<std::uint64_t>(std::max<std::uint64_t>(got / 2, 4096), most + 1 - got));
    }
    const std::optional<std::size_t> more = read_some(bytes.data() + got, bytes.size() - got);
    if (!more) return false;
    if (*more == 0) break;
    got += *more;
  }
  bytes.resize(got);
  return true;
}

std::string read_input_file(const fs::path& path, std::uint64_t most) {
  InputFile input = open_input(path);
  std::string bytes;
  const bool whole = input.file && within_memory(path, [&] { return input.read(bytes, most); });
  if (!whole) throw InputError(path.string() + ": " + input.error);
  return bytes;
}

InputError out_of_memory_for(const fs::path& path) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(path, error);
  char text[32] = "unknown size";
  if (!error) std::snprintf(text, sizeof text, "%.1f MB", static_cast<double>(size) / 1e6);
  return InputError(path.string() + ": the file (" + text +
                    ") needs more memory than there is; take a smaller one or a machine with more");
}

}  // namespace tactor
