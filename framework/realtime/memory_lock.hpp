// Keeps the memory of the process where it is, so that no loop waits for a page.
#pragma once

#include <optional>

#include "framework/realtime/privilege.hpp"

namespace tactor {

/// What stands against locking memory, or nothing. Locking needs CAP_IPC_LOCK or an unlimited RLIMIT_MEMLOCK: under a
/// limit the kernel would accept the lock and then fail allocations at random when the limit is reached.
std::optional<Refusal> memory_lock_refusal();

/// While it lives, all memory of the process stays in RAM, the stacks of threads in full included (so give threads
/// stacks of the size they need). Where that is refused it locks nothing and tells why.
///
/// Either way glibc's heap from then on keeps what is freed instead of giving it back to the system, so that what was
/// touched once stays mapped; that lasts until the process ends.
class MemoryLock {
 public:
  MemoryLock();
  ~MemoryLock();
  MemoryLock(const MemoryLock&) = delete;
  MemoryLock& operator=(const MemoryLock&) = delete;

  [[nodiscard]] bool locked() const { return !refused_; }
  [[nodiscard]] const std::optional<Refusal>& refused() const { return refused_; }

 private:
  std::optional<Refusal> refused_;
};

}  // namespace tactor
