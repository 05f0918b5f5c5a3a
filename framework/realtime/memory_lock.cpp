// mlockall where it is safe, and the settings of glibc's heap.
#include "framework/realtime/memory_lock.hpp"

#include <malloc.h>
#include <sys/mman.h>
#include <sys/resource.h>

#include <cerrno>
#include <cstring>

namespace tactor {

namespace {

constexpr const char* what = "locking memory";

}  // namespace

std::optional<Refusal> memory_lock_refusal() {
  if (has_capability(Capability::ipc_lock)) return std::nullopt;
  const std::uint64_t limit = raised_limit(RLIMIT_MEMLOCK);
  if (limit == RLIM_INFINITY) return std::nullopt;
  return Refusal{what, "the limit memlock is " + std::to_string(limit / 1024) + " KiB and CAP_IPC_LOCK is missing",
                 privilege_remedy(Capability::ipc_lock, "memlock", "unlimited")};
}

MemoryLock::MemoryLock() : refused_(memory_lock_refusal()) {
  mallopt(M_TRIM_THRESHOLD, -1);
  mallopt(M_MMAP_MAX, 0);
  if (!refused_ && mlockall(MCL_CURRENT | MCL_FUTURE) != 0) refused_ = Refusal{what, std::strerror(errno), ""};
}

MemoryLock::~MemoryLock() {
  if (locked()) munlockall();
}

}  // namespace tactor
