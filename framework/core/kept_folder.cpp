#include "framework/core/kept_folder.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <limits.h>
#include <pwd.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <deque>
#include <memory>
#include <vector>

#include "framework/core/check.hpp"
#include "framework/core/installation.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

constexpr mode_t folder_mode = 0700;
constexpr mode_t file_mode = 0600;
constexpr const char* part_infix = ".part.";

[[noreturn]] void refuse(const std::string& path, const std::string& why) {
  throw RunError(path + ": " + why);
}

std::string name_of(uid_t user) {
  std::vector<char> texts(1 << 14);
  passwd entry{};
  passwd* found = nullptr;
  if (getpwuid_r(user, &entry, texts.data(), texts.size(), &found) == 0 && found != nullptr) return found->pw_name;
  return "number " + std::to_string(user);
}

enum class Owner : std::uint8_t { user, user_or_root };

/// Refuses what another user owns or may write.
void demand_ours(const struct stat& status, const std::string& path, Owner owner = Owner::user) {
  if (status.st_uid != geteuid() && !(owner == Owner::user_or_root && status.st_uid == 0)) {
    const std::string whose = name_of(status.st_uid);
    refuse(path, "belongs to the user " + whose + " and not to " + name_of(geteuid()) +
                     ", who runs the program; it is not used; run the program as " + whose +
                     ", or make one of your own");
  }
  if ((status.st_mode & (S_IWGRP | S_IWOTH)) != 0) {
    refuse(path, "other users may write it, so it is not used; if you trust its content, run chmod go-w on it");
  }
}

/// Follows a path from the root, one name at a time, so that what was checked is what is used.
class Walk {
 public:
  Walk(const fs::path& path, bool make, KeptFolder::Decides decides = KeptFolder::Decides::nothing)
      : make_(make), decides_(decides), at_(::open("/", O_PATH | O_DIRECTORY | O_CLOEXEC)) {
    if (!at_) refuse("/", std::strerror(errno));
    put_before(path.relative_path());
  }

  /// The folder at the end, open for listing; none where a part of the way is missing and nothing is to be made.
  FileDescriptor end() {
    while (!names_.empty()) {
      if (!step(next_name())) return {};
    }
    demand_own_folder(Owner::user);
    FileDescriptor folder(::openat(at_.number(), ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (!folder) refuse(seen_.string(), std::strerror(errno));
    return folder;
  }

  /// The file at the end, and its folder.
  ProgramsFile file() {
    while (!names_.empty()) {
      const std::string name = next_name();
      if (names_.empty() && is_file(name)) {
        demand_own_folder(Owner::user_or_root);
        const std::string path = (seen_ / name).string();
        FileDescriptor file(::openat(at_.number(), name.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
        if (!file) refuse(path, std::strerror(errno));
        struct stat status {};
        if (::fstat(file.number(), &status) != 0) refuse(path, std::strerror(errno));
        if (!S_ISREG(status.st_mode)) refuse(path, "is not a regular file");
        demand_ours(status, path, Owner::user_or_root);
        return {std::move(file), seen_};
      }
      if (!step(name)) return {};
    }
    refuse(seen_.string(), "is not a regular file");
  }

 private:
  std::string next_name() {
    std::string name = names_.front();
    names_.pop_front();
    return name;
  }

  [[nodiscard]] bool is_file(const std::string& name) const {
    struct stat status {};
    return ::fstatat(at_.number(), name.c_str(), &status, AT_SYMLINK_NOFOLLOW) == 0 && !S_ISLNK(status.st_mode) &&
           !S_ISDIR(status.st_mode);
  }

  void demand_own_folder(Owner owner) const {
    struct stat status {};
    if (::fstat(at_.number(), &status) != 0) refuse(seen_.string(), std::strerror(errno));
    demand_ours(status, seen_.string(), owner);
  }

  /// In a folder that all may write and without the sticky bit, anybody may put another entry in the place of one.
  void demand_kept_entries() const {
    struct stat status {};
    if (::fstat(at_.number(), &status) != 0) refuse(seen_.string(), std::strerror(errno));
    if ((status.st_mode & S_IWOTH) == 0 || (status.st_mode & S_ISVTX) != 0) return;
    refuse(seen_.string(),
           "all users may replace what is in it, so that it is not used; run chmod o-w on it, or "
           "chmod +t if all are to write there");
  }

  void put_before(const fs::path& relative) {
    std::vector<std::string> names;
    for (const fs::path& name : relative) {
      if (!name.empty() && name != ".") names.push_back(name.string());
    }
    names_.insert(names_.begin(), names.begin(), names.end());
  }

  FileDescriptor look(const std::string& name) const {
    return FileDescriptor(::openat(at_.number(), name.c_str(), O_PATH | O_NOFOLLOW | O_CLOEXEC));
  }

  bool step(const std::string& name) {
    if (decides_ == KeptFolder::Decides::programs) demand_kept_entries();
    const std::string path = (seen_ / name).string();
    FileDescriptor next = look(name);
    if (!next && errno == ENOENT) {
      if (!make_) return false;
      if (::mkdirat(at_.number(), name.c_str(), folder_mode) != 0 && errno != EEXIST) {
        refuse(path, std::string("cannot be made: ") + std::strerror(errno));
      }
      next = look(name);
    }
    struct stat status {};
    if (!next || ::fstat(next.number(), &status) != 0) refuse(path, std::strerror(errno));
    if (S_ISLNK(status.st_mode)) {
      follow(next, status, path);
    } else if (S_ISDIR(status.st_mode)) {
      at_ = std::move(next);
      seen_ = name == ".." ? seen_.parent_path() : fs::path(path);
    } else {
      refuse(path, "is not a folder");
    }
    return true;
  }

  void follow(const FileDescriptor& link, const struct stat& status, const std::string& path) {
    constexpr int most_links = 40;
    if (status.st_uid != 0 && status.st_uid != geteuid()) {
      refuse(path, "is a link of the user " + name_of(status.st_uid) + ", which is not followed");
    }
    if (++links_ > most_links) refuse(path, std::strerror(ELOOP));
    std::array<char, PATH_MAX> target{};
    const ssize_t size = ::readlinkat(link.number(), "", target.data(), target.size());
    if (size <= 0 || size == static_cast<ssize_t>(target.size())) refuse(path, "the link cannot be read");
    const fs::path to(std::string_view(target.data(), static_cast<std::size_t>(size)));
    if (to.is_absolute()) {
      at_ = FileDescriptor(::open("/", O_PATH | O_DIRECTORY | O_CLOEXEC));
      if (!at_) refuse("/", std::strerror(errno));
      seen_ = "/";
    }
    put_before(to.relative_path());
  }

  bool make_;
  KeptFolder::Decides decides_;
  FileDescriptor at_;
  fs::path seen_ = "/";
  std::deque<std::string> names_;
  int links_ = 0;
};

void demand_name(const std::string& name) {
  TACTOR_DEMAND(!name.empty() && name != "." && name != ".." && name.find('/') == std::string::npos);
}

void demand_our_file(const FileDescriptor& file, const std::string& path) {
  struct stat status {};
  if (::fstat(file.number(), &status) != 0) refuse(path, std::strerror(errno));
  if (!S_ISREG(status.st_mode)) refuse(path, "is not a regular file; remove it");
  demand_ours(status, path);
}

}  // namespace

KeptFolder KeptFolder::make(const fs::path& path) {
  if (path.empty()) {
    throw RunError("there is no folder to keep files in: no variable names one, HOME is not set and the user " +
                   name_of(geteuid()) + " has no home folder; set HOME");
  }
  return {path, Walk(fs::absolute(path), true).end()};
}

std::optional<KeptFolder> KeptFolder::find(const fs::path& path, Decides decides) {
  if (path.empty()) return std::nullopt;
  FileDescriptor folder = Walk(fs::absolute(path), false, decides).end();
  if (!folder) return std::nullopt;
  return KeptFolder(path, std::move(folder));
}

std::string KeptFolder::named(const std::string& name) const {
  demand_name(name);
  return (path_ / name).string();
}

std::optional<FileDescriptor> KeptFolder::open(const std::string& name) const {
  const std::string path = named(name);
  // O_NONBLOCK: a pipe that stands there must not make the program wait.
  FileDescriptor file(::openat(folder_.number(), name.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  if (!file && errno == ENOENT) return std::nullopt;
  if (!file && errno == ELOOP) refuse(path, "is a link, which is not followed; remove it");
  if (!file) refuse(path, std::strerror(errno));
  demand_our_file(file, path);
  return file;
}

void KeptFolder::remove_stale_parts() const {
  constexpr std::time_t day = 24 * 60 * 60;
  const int listed = ::openat(folder_.number(), ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  const std::unique_ptr<DIR, int (*)(DIR*)> entries(listed < 0 ? nullptr : ::fdopendir(listed), ::closedir);
  if (!entries) return;
  const std::time_t now = std::time(nullptr);
  while (const dirent* entry = ::readdir(entries.get())) {
    struct stat status {};
    if (std::strstr(entry->d_name, part_infix) == nullptr) continue;
    if (::fstatat(folder_.number(), entry->d_name, &status, AT_SYMLINK_NOFOLLOW) != 0) continue;
    if (now - status.st_mtim.tv_sec > day) ::unlinkat(folder_.number(), entry->d_name, 0);
  }
}

void KeptFolder::write(const std::string& name, std::initializer_list<std::string_view> parts) const {
  const std::string path = named(name);
  remove_stale_parts();
  static std::atomic<unsigned> made{0};
  std::string part;
  FileDescriptor file;
  do {
    part = name + part_infix + std::to_string(::getpid()) + "." + std::to_string(made++);
    file = FileDescriptor(
        ::openat(folder_.number(), part.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, file_mode));
  } while (!file && errno == EEXIST);
  if (!file) refuse(path, std::strerror(errno));
  bool written = true;
  for (const std::string_view bytes : parts) written = written && file.write_all(bytes.data(), bytes.size());
  written = written && ::fsync(file.number()) == 0 && file.close() &&
            ::renameat(folder_.number(), part.c_str(), folder_.number(), name.c_str()) == 0;
  if (written) return;
  const int reason = errno;
  ::unlinkat(folder_.number(), part.c_str(), 0);
  refuse(path, std::strerror(reason));
}

void KeptFolder::remove(const std::string& name) const {
  const std::string path = named(name);
  if (::unlinkat(folder_.number(), name.c_str(), 0) != 0 && errno != ENOENT) refuse(path, std::strerror(errno));
}

ProgramsFile open_programs_file(const fs::path& path) {
  std::error_code ignored;
  const fs::path real = fs::canonical(path, ignored), prefix = fs::canonical(installation_prefix(), ignored);
  for (const fs::path& folder : {prefix / "clusters", prefix / "share" / "tactor" / "clusters"}) {
    if (real.parent_path() == folder) {
      return {FileDescriptor(::open(real.c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC)), folder};
    }
  }
  return Walk(fs::absolute(path), false, KeptFolder::Decides::programs).file();
}

}  // namespace tactor
