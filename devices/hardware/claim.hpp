// One owner a device: a claim that holds among the programs of one machine, and who has it.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

namespace tactor {

/// What nobody else on this machine can have at the same time. It is a name that the kernel keeps, of an abstract
/// socket: no file is made, users share it, and it goes with its process, however that ends. It is advisory: only
/// programs that ask are kept away. A network namespace (a container) has names of its own.
class Claim {
 public:
  Claim() = default;
  /// Who else may have the name: nobody, or other claims of this process that share it too.
  enum class Sharing : std::uint8_t { alone, process };
  /// Takes the name, or tells in `why` who has it, or what else keeps it from being taken. Returns whether it is held
  /// now. Nothing happens where this claim has that name already; another one is given up first.
  bool take(const std::string& name, std::string& why, Sharing sharing = Sharing::alone);
  void release() { socket_.reset(); }
  [[nodiscard]] bool held() const { return socket_ != nullptr; }

 private:
  struct Socket;
  std::shared_ptr<Socket> socket_;
  std::string name_;
};

/// `process 4711 (tactor run duck.yaml)`, or without the command where it may not be seen. Of a guard it is the engine
/// that it works for, which is what a user knows of.
std::string process_text(int process);

/// Why a device cannot be had, and what to do, where `holder` (a `process_text`, or empty where unknown) has it.
std::string in_use_by(const std::string& holder);

/// The other processes that have this file open, as `process_text`, joined by commas; empty where none can be seen.
std::string users_of(const std::string& file);

/// A serial port that no other program uses: locked (flock, which other programs that lock ports see too), and from
/// `exclude` on not to be opened by anybody but root. Both end with the process. A pseudo-terminal is locked alone:
/// what holds its other end would keep it closed after this process was killed.
class PortLock {
 public:
  PortLock() = default;
  ~PortLock() { release(); }
  PortLock(const PortLock&) = delete;
  PortLock& operator=(const PortLock&) = delete;
  /// Opens and locks it before anything is done to it. False, with why and what to do, where another program has it or
  /// this user may not; true also if there is nothing to open: opening it for use will report that.
  bool take(const std::string& path, std::string& why);
  void exclude();
  void release();

 private:
  int file_ = -1;
  bool excludes_ = false;
};

/// The process that has locked the file by flock, as `process_text`; empty where it cannot be seen.
std::string locker_of(int file);

}  // namespace tactor
