// One writer of a file at a time, on every file system.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <string>

namespace tactor {

/// Which lock of the system is meant.
enum class LockKind : std::uint8_t {
  whole,      ///< flock of the file, which nobody else can have
  shared,     ///< flock of the file, which others can have too, but nobody alone
  beside,     ///< of a byte far beyond the end, so that who reads the file and locks that is not hindered
  of_region,  ///< fcntl of the process, as SQLite locks
};

enum class LockAnswer : std::uint8_t {
  taken,
  busy,  ///< somebody else has it
  none,  ///< there are no such locks here: a file system of a cluster may be without (Lustre, NFS)
};

/// Asks for a lock on an open file, once and without waiting. The system lets go of it when the file is closed.
LockAnswer ask_for_lock(int file, LockKind kind);

/// Keeps other processes from writing a file. Where the file system has no locks, a file of its own says who writes,
/// PATH.held, made so that only one can make it. It goes with its owner; of a process that was killed it stays, and the
/// next one on the same machine sees that and takes it over. On another machine that cannot be told: there the lock
/// stays busy, and `holder` says which file to remove. To go on without any lock would mix two tables.
class WriteLock {
 public:
  WriteLock() = default;
  ~WriteLock() { release(); }
  WriteLock(WriteLock&& other) noexcept;
  WriteLock& operator=(WriteLock&& other) noexcept;

  /// Asks once, without waiting, for the lock of `path`, which is open for writing as `file` and stays so for as long
  /// as the lock is to be had. False where another process has it, and `holder` tells what is known of that. Throws
  /// RunError where neither lock can be had.
  bool take(int file, const std::filesystem::path& path, LockKind kind = LockKind::whole);
  /// ` (process 4711 on node7; ...)`, or empty where nothing is known.
  [[nodiscard]] const std::string& holder() const { return holder_; }
  /// Removes the file that says who writes; the lock of the system goes when the file is closed.
  void release();

 private:
  bool make_sign(const std::filesystem::path& sign);
  bool take_over(const std::filesystem::path& sign, const std::string& ended);

  std::filesystem::path sign_;  ///< the file that says who writes, where there is one
  pid_t maker_ = 0;             ///< whose file it is: a process that is forked has this object too
  std::string holder_;
};

}  // namespace tactor
