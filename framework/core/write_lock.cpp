#include "framework/core/write_lock.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <utility>

#include "framework/core/check.hpp"
#include "framework/core/file_descriptor.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

LockAnswer answer_of(int result) {
  if (result == 0) return LockAnswer::taken;
  // Every other answer (ENOSYS, ENOLCK, EOPNOTSUPP, EINVAL, ...) is of a file system that has no locks to give.
  return errno == EWOULDBLOCK || errno == EACCES ? LockAnswer::busy : LockAnswer::none;
}

int lock_region(int file, int command, off_t start, off_t length) {
  struct flock lock {};
  lock.l_type = F_WRLCK;
  lock.l_whence = SEEK_SET;
  lock.l_start = start;
  lock.l_len = length;
  return ::fcntl(file, command, &lock);
}

int lock_once(int file, LockKind kind) {
  switch (kind) {
    case LockKind::whole:
      return ::flock(file, LOCK_EX | LOCK_NB);
    case LockKind::shared:
      return ::flock(file, LOCK_SH | LOCK_NB);
    case LockKind::beside:
      return lock_region(file, F_OFD_SETLK, off_t{1} << 61, 1);
    case LockKind::of_region:
      return lock_region(file, F_SETLK, 0, 0);
  }
  TACTOR_DEMAND(false);
}

std::string bytes_of_file(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::string word_in(const fs::path& file) {
  std::ifstream stream(file);
  std::string word;
  stream >> word;
  return word;
}

/// When a process began, in ticks of this machine's clock; empty where there is none of that number, or it may not be
/// seen; `gone` where it has ended and nobody has asked how.
std::string begin_of(pid_t process) {
  const std::string stat = bytes_of_file("/proc/" + std::to_string(process) + "/stat");
  const std::size_t name_end = stat.rfind(')');  // the name, in round brackets, may hold anything
  if (name_end == std::string::npos) return {};
  std::istringstream fields(stat.substr(name_end + 1));
  std::string state, field;
  fields >> state;
  if (state == "Z" || state == "X") return "gone";
  constexpr int fields_to_begin = 19;  // field 22 of all
  for (int i = 0; i < fields_to_begin; ++i) fields >> field;
  return fields ? field : std::string();
}

/// Who writes: a process, and where its number means something.
struct Writer {
  pid_t process = 0;
  std::string begin, boot, space, machine;

  static Writer here() {
    utsname names{};
    ::uname(&names);
    std::error_code ignored;
    return {::getpid(), begin_of(::getpid()), word_in("/proc/sys/kernel/random/boot_id"),
            fs::read_symlink("/proc/self/ns/pid", ignored).string(), names.nodename};
  }
  static std::optional<Writer> of(const std::string& text) {
    Writer writer;
    std::istringstream words(text);
    words >> writer.process >> writer.begin >> writer.boot >> writer.space >> writer.machine;
    return words ? std::optional(writer) : std::nullopt;
  }
  [[nodiscard]] std::string text() const {
    return std::to_string(process) + " " + begin + " " + boot + " " + space + " " + machine + "\n";
  }
  /// Whether its process can be looked for from here.
  [[nodiscard]] bool is_near(const Writer& here) const {
    return !boot.empty() && !space.empty() && boot == here.boot && space == here.space;
  }
  [[nodiscard]] bool has_ended() const {
    if (::kill(process, 0) != 0 && errno == ESRCH) return true;
    const std::string now = begin_of(process);  // of another process that has got the number since
    return !now.empty() && now != begin;
  }
};

/// Makes a file that is not there yet; false where it is.
bool make_new(const fs::path& path, const std::string& text) {
  FileDescriptor file(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0644));
  if (!file) {
    // Over NFS a file may be made and the answer lost; asked again, it is there already.
    if (errno == EEXIST) return bytes_of_file(path) == text;
    throw RunError("cannot write " + path.string() + ": " + std::strerror(errno));
  }
  if (file.write_all(text.data(), text.size()) && ::fsync(file.number()) == 0 && file.close()) return true;
  const int error = errno;
  ::unlink(path.c_str());
  throw RunError("cannot write " + path.string() + ": " + std::strerror(error));
}

fs::path with_ending(fs::path path, const char* ending) {
  path += ending;
  return path;
}

}  // namespace

LockAnswer ask_for_lock(int file, LockKind kind) {
  int result = 0;
  do {
    result = lock_once(file, kind);
  } while (result != 0 && errno == EINTR);
  return answer_of(result);
}

WriteLock::WriteLock(WriteLock&& other) noexcept
    : sign_(std::exchange(other.sign_, {})), maker_(other.maker_), holder_(std::move(other.holder_)) {}

WriteLock& WriteLock::operator=(WriteLock&& other) noexcept {
  if (this == &other) return *this;
  release();
  sign_ = std::exchange(other.sign_, {});
  maker_ = other.maker_;
  holder_ = std::move(other.holder_);
  return *this;
}

bool WriteLock::take(int file, const fs::path& path, LockKind kind) {
  release();
  holder_.clear();
  const LockAnswer answer = ask_for_lock(file, kind);
  return answer == LockAnswer::none ? make_sign(with_ending(path, ".held")) : answer == LockAnswer::taken;
}

bool WriteLock::make_sign(const fs::path& sign) {
  const Writer here = Writer::here();
  // In this process another object may have it, with the same text.
  const bool is_mine = bytes_of_file(sign) == here.text();
  if (!is_mine && make_new(sign, here.text())) {
    sign_ = sign;
    maker_ = here.process;
    return true;
  }
  const std::string text = bytes_of_file(sign);
  const std::optional<Writer> writer = Writer::of(text);
  if (writer && writer->is_near(here)) {
    if (writer->has_ended() && take_over(sign, text)) return true;
    holder_ = " (process " + std::to_string(writer->process) + ")";
    return false;
  }
  holder_ = " (" + (writer ? "process " + std::to_string(writer->process) + " on " + writer->machine : "unknown") +
            "; if it has ended, remove " + sign.string() + ")";
  return false;
}

bool WriteLock::take_over(const fs::path& sign, const std::string& ended) {
  // One at a time, so that nobody removes what another one has made meanwhile.
  const std::string mine = Writer::here().text();
  const fs::path turn = with_ending(sign, ".turn");
  if (!make_new(turn, mine)) return false;
  bool taken = false;
  if (bytes_of_file(sign) == ended && ::unlink(sign.c_str()) == 0) taken = make_new(sign, mine);
  ::unlink(turn.c_str());
  if (!taken) return false;
  sign_ = sign;
  maker_ = ::getpid();
  return true;
}

void WriteLock::release() {
  if (!sign_.empty() && maker_ == ::getpid()) ::unlink(sign_.c_str());
  sign_.clear();
}

}  // namespace tactor
