#include "framework/realtime/flight_file.hpp"

#include <fcntl.h>
#include <linux/magic.h>
#include <sys/mman.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <system_error>

#include "framework/core/check.hpp"
#include "framework/core/kept_folder.hpp"
#include "framework/core/user_folders.hpp"
#include "framework/core/write_lock.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t most_left = 3;  // files of ended processes
constexpr const char* flight_suffix = ".ring";

/// True where `path`, or the nearest folder above it that is there, is in memory.
bool is_in_memory(fs::path path) {
  struct statfs system {};
  while (::statfs(path.c_str(), &system) != 0) {
    if (!path.has_relative_path()) return false;
    path = path.parent_path();
  }
  return system.f_type == TMPFS_MAGIC || system.f_type == RAMFS_MAGIC;
}

/// The folder of the user's flight files; empty where no file system is in memory.
fs::path flight_folder() {
  if (const fs::path runtime = runtime_folder(); !runtime.empty() && is_in_memory(runtime)) return runtime / "flight";
  const fs::path shared = "/dev/shm";
  return is_in_memory(shared) ? shared / ("tactor-" + std::to_string(geteuid())) : fs::path();
}

/// The number of the process in a name such as `duck-4711.ring`; 0: there is none.
long process_of(const fs::path& file) {
  const std::string stem = file.stem().string();
  const std::size_t dash = stem.rfind('-');
  long number = 0;
  if (dash == std::string::npos || file.extension() != flight_suffix) return 0;
  const char* end = stem.data() + stem.size();
  const auto [stop, error] = std::from_chars(stem.data() + dash + 1, end, number);
  return error == std::errc{} && stop == end ? number : 0;
}

/// True where another process holds the lock of the file.
bool is_held(const fs::path& path) {
  const FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
  return file && ask_for_lock(file.number(), LockKind::whole) == LockAnswer::busy;
}

void remove_old_flights() {
  std::size_t left = 0;
  for (const FoundFlight& found : find_flights()) {
    std::error_code ignored;
    if (!found.is_running && ++left > most_left) fs::remove(found.path, ignored);
  }
}

/// A name that a file may have: what else is in it becomes `_`.
std::string file_name_of(const std::string& graph) {
  std::string name = graph.substr(0, 64);
  std::replace_if(
      name.begin(), name.end(),
      [](char c) { return !(('a' <= c && c <= 'z') || ('A' <= c && c <= 'Z') || ('0' <= c && c <= '9')); }, '_');
  return name + "-" + std::to_string(getpid()) + flight_suffix;
}

[[noreturn]] void refuse_flight(const fs::path& path, int error) {
  throw RunError("cannot make " + path.string() + ": " + std::strerror(error));
}

}  // namespace

FlightFile::FlightFile(const std::string& name, const FlightRing::Description& description) {
  const fs::path folder = flight_folder();
  if (folder.empty()) throw RunError("neither XDG_RUNTIME_DIR nor /dev/shm is in memory");
  static_cast<void>(KeptFolder::make(folder));
  remove_old_flights();
  path_ = folder / file_name_of(name);
  std::error_code ignored;
  fs::remove(path_, ignored);  // of a process that had this number before
  file_ = FileDescriptor(::open(path_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0600));
  if (!file_) refuse_flight(path_, errno);
  const std::size_t size = FlightRing::bytes(description);
  // All of it now: a file system that is full would end the process at a write.
  const int full = ::posix_fallocate(file_.number(), 0, static_cast<off_t>(size));
  void* memory = full == 0 ? ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED, file_.number(), 0) : MAP_FAILED;
  if (memory == MAP_FAILED) {
    const int error = full != 0 ? full : errno;
    fs::remove(path_, ignored);
    refuse_flight(path_, error);
  }
  memory_ = {static_cast<std::byte*>(memory), size};
  static_cast<void>(ask_for_lock(file_.number(), LockKind::whole));
  ring_.emplace(memory_, description);
  ring_->set_file(file_.number());
  // Refused where MemoryLock is refused too, which tells it.
  static_cast<void>(::mlock(memory, size));
}

FlightFile::~FlightFile() {
  std::error_code ignored;
  if (!moved_ && !is_to_stay()) fs::remove(path_, ignored);
  ::munmap(memory_.data(), memory_.size());
}

bool FlightFile::is_to_stay() const {
  return asked_ || ring_->has_fault() || ring_->end() == FlightEnd::failed;
}

void FlightFile::move_to(const fs::path& target) {
  std::error_code ignored;
  fs::remove(target, ignored);
  std::ofstream out(target, std::ios::binary);
  out.write(reinterpret_cast<const char*>(memory_.data()), static_cast<std::streamsize>(memory_.size()));
  out.close();
  if (!out)
    throw RunError("cannot write " + target.string() + "; the flight recorder's file stays at " + path_.string());
  fs::remove(path_, ignored);
  path_ = target;
  moved_ = true;
}

std::vector<FoundFlight> find_flights() {
  std::vector<FoundFlight> found;
  const fs::path folder = flight_folder();
  if (!KeptFolder::find(folder)) return found;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const long process = process_of(entry.path());
    if (process == 0 || !entry.is_regular_file(error)) continue;
    found.push_back({entry.path(), entry.last_write_time(error), process, is_held(entry.path())});
  }
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.begun > b.begun; });
  return found;
}

}  // namespace tactor
