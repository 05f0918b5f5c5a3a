#include "devices/hardware/claim.hpp"

#include <fcntl.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <sys/un.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <mutex>
#include <string_view>

#include "devices/hardware/device_descriptors.hpp"
#include "devices/hardware/serial_ports.hpp"
#include "framework/core/write_lock.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view prefix = "tactor device ";
constexpr std::size_t longest_command = 120;
constexpr int waiting_askers = 4096;

struct Address {
  sockaddr_un name{};
  socklen_t length = 0;
};

/// The address of a name in the kernel's own space: a zero, and then the name without an end.
Address address_of(const std::string& name) {
  Address address;
  address.name.sun_family = AF_UNIX;
  std::string text = std::string(prefix) + name;
  constexpr std::size_t room = sizeof address.name.sun_path - 1;
  if (text.size() > room) {
    const std::string mark = "#" + std::to_string(std::hash<std::string>{}(text));
    text = text.substr(0, room - mark.size()) + mark;
  }
  std::memcpy(address.name.sun_path + 1, text.data(), text.size());
  address.length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + text.size());
  return address;
}

/// Who listens there; 0 where nobody does any more, or it cannot be told.
int listener_at(const Address& address) {
  const int file = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (file < 0) return 0;
  ucred who{};
  socklen_t size = sizeof who;
  const bool known = connect(file, reinterpret_cast<const sockaddr*>(&address.name), address.length) == 0 &&
                     getsockopt(file, SOL_SOCKET, SO_PEERCRED, &who, &size) == 0;
  close(file);
  return known ? who.pid : 0;
}

/// Gives a terminal another setting than the one that it is opened for. A pseudo-terminal ignores the parity, which the
/// C library takes for a refusal of all settings where nothing else changes: as after a program that was killed and had
/// set the others.
void unsettle(int file) {
  termios settings{};
  if (tcgetattr(file, &settings) != 0) return;
  settings.c_iflag |= IXANY;  // without IXON it means nothing, and whoever uses the port takes it away
  tcsetattr(file, TCSANOW, &settings);
}

}  // namespace

struct Claim::Socket {
  int file = -1;
  ~Socket() { close_kept(file); }
};

bool Claim::take(const std::string& name, std::string& why, Sharing sharing) {
  if (socket_ != nullptr && name == name_) return true;
  release();
  static std::mutex mutex;
  static std::map<std::string, std::weak_ptr<Socket>> shared;
  const std::scoped_lock lock(mutex);
  if (sharing == Sharing::process) {
    socket_ = shared[name].lock();
    name_ = name;
    if (socket_ != nullptr) return true;
  }
  auto made = std::make_shared<Socket>();
  {
    const NoFork until_kept;
    made->file = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    keep_from_children(made->file);
  }
  const Address address = address_of(name);
  if (made->file < 0 || bind(made->file, reinterpret_cast<const sockaddr*>(&address.name), address.length) != 0 ||
      listen(made->file, waiting_askers) != 0) {
    const int error = errno;
    const int pid = error == EADDRINUSE ? listener_at(address) : 0;
    why = error == EADDRINUSE ? in_use_by(pid == 0 ? "" : process_text(pid))
                              : std::string("cannot be claimed for this program alone: ") + std::strerror(error);
    return false;
  }
  if (sharing == Sharing::process) shared[name] = made;
  socket_ = std::move(made);
  name_ = name;
  return true;
}

namespace {

/// The engine that a guard works for, as long as it is there; else the process itself.
int engine_of(int pid) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/cmdline", std::ios::binary);
  std::string program, engine;
  std::getline(file, program, '\0');
  std::getline(file, engine, '\0');
  const bool is_guard = fs::path(program).filename() == "tactor-guard" && !engine.empty() &&
                        engine.find_first_not_of("0123456789") == std::string::npos && engine.size() < 10;
  std::error_code error;
  return is_guard && fs::exists("/proc/" + engine, error) ? std::stoi(engine) : pid;
}

}  // namespace

std::string process_text(int process) {
  const int pid = engine_of(process);
  std::string text = pid == getpid() ? "this process, " + std::to_string(pid) : "process " + std::to_string(pid);
  std::ifstream file("/proc/" + std::to_string(pid) + "/cmdline", std::ios::binary);
  std::string command{std::istreambuf_iterator<char>(file), {}};
  while (!command.empty() && command.back() == '\0') command.pop_back();
  std::replace(command.begin(), command.end(), '\0', ' ');
  // What a terminal would obey is not shown.
  std::replace_if(
      command.begin(), command.end(), [](char c) { return static_cast<unsigned char>(c) < ' '; }, '?');
  if (command.size() > longest_command) command = command.substr(0, longest_command) + "...";
  return command.empty() ? text : text + " (" + command + ")";
}

std::string in_use_by(const std::string& holder) {
  return "in use by " + (holder.empty() ? "another program" : holder) +
         "; only one program can own a device: end that one first";
}

std::string users_of(const std::string& file) {
  std::error_code error;
  const fs::path wanted = fs::canonical(file, error);
  std::string users;
  for (const auto& process : fs::directory_iterator("/proc", error)) {
    const std::string pid = process.path().filename().string();
    if (pid.find_first_not_of("0123456789") != std::string::npos || pid == std::to_string(getpid())) continue;
    std::error_code closed;
    for (const auto& entry : fs::directory_iterator(process.path() / "fd", closed)) {
      if (fs::read_symlink(entry.path(), closed) != wanted) continue;
      users += (users.empty() ? "" : ", ") + process_text(std::stoi(pid));
      break;
    }
  }
  return users;
}

bool PortLock::take(const std::string& path, std::string& why) {
  release();
  {
    const NoFork until_kept;
    file_ = open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    keep_from_children(file_);
  }
  if (file_ < 0) {
    if (errno == EACCES || errno == EPERM) {
      why = "Permission denied: " + advice_for_access(path);
      return false;
    }
    if (errno != EBUSY) return true;
    why = in_use_by(users_of(path));
    return false;
  }
  // A system without locks for ports has other means: who opens it afterwards is kept out by `exclude`.
  if (ask_for_lock(file_, LockKind::whole) != LockAnswer::busy) {
    unsettle(file_);
    return true;
  }
  why = in_use_by(locker_of(file_));
  release();
  return false;
}

void PortLock::exclude() {
  constexpr unsigned first_pty = 136, last_pty = 143;  // of Linux
  struct stat status {};
  if (file_ < 0 || fstat(file_, &status) != 0 || !S_ISCHR(status.st_mode)) return;
  if (major(status.st_rdev) >= first_pty && major(status.st_rdev) <= last_pty) return;
  excludes_ = ioctl(file_, TIOCEXCL) == 0;
}

void PortLock::release() {
  if (file_ < 0) return;
  // It belongs to the port: it would outlive this file, and keep us out, where another program has the port open.
  if (excludes_) ioctl(file_, TIOCNXCL);
  excludes_ = false;
  close_kept(file_);
  file_ = -1;
}

std::string locker_of(int file) {
  struct stat status {};
  if (fstat(file, &status) != 0) return {};
  char inode[64];
  std::snprintf(inode, sizeof inode, " %02x:%02x:%llu ", major(status.st_dev), minor(status.st_dev),
                static_cast<unsigned long long>(status.st_ino));
  std::ifstream locks("/proc/locks");
  for (std::string line; std::getline(locks, line);) {
    int pid = 0;
    if (line.find(inode) == std::string::npos || line.find("FLOCK") == std::string::npos) continue;
    if (std::sscanf(line.c_str(), "%*s FLOCK %*s %*s %d", &pid) == 1 && pid > 0) return process_text(pid);
  }
  return {};
}

}  // namespace tactor
