#include "devices/hardware/device_descriptors.hpp"

#include <fcntl.h>
#include <pthread.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <memory>
#include <mutex>
#include <shared_mutex>
#include <vector>

namespace tactor {

namespace {

struct KeptDescriptors {
  std::mutex turn;            // who forks goes before those that begin to open later
  std::shared_mutex opening;  // held for itself by who forks
  std::mutex mutex;           // over the numbers
  std::vector<int> numbers;
};

void before_fork();
void after_fork_in_parent();
void after_fork_in_child();

/// Lives as long as the process, because the last fork may come late.
KeptDescriptors& kept() {
  static KeptDescriptors& one = []() -> KeptDescriptors& {
    pthread_atfork(before_fork, after_fork_in_parent, after_fork_in_child);
    return *new KeptDescriptors;
  }();
  return one;
}

thread_local int held = 0;  // objects of NoFork on this thread

void before_fork() {
  kept().turn.lock();
  kept().opening.lock();
  kept().mutex.lock();
}

void after_fork_in_parent() {
  kept().mutex.unlock();
  kept().opening.unlock();
  kept().turn.unlock();
}

/// Only the thread that forked is here. The system call itself, because an emulator stands before that of the library.
void after_fork_in_child() {
  for (const int number : kept().numbers) syscall(SYS_close, number);
  kept().numbers.clear();
  // Made anew, because the C library lets only the thread that has locked one unlock it, and this is another by name.
  std::construct_at(&kept().turn);
  std::construct_at(&kept().opening);
  std::construct_at(&kept().mutex);
}

}  // namespace

NoFork::NoFork() {
  if (held++ > 0) return;
  const std::scoped_lock in_turn(kept().turn);
  kept().opening.lock_shared();
}

NoFork::~NoFork() {
  if (--held == 0) kept().opening.unlock_shared();
}

void keep_from_children(int descriptor) {
  if (descriptor < 0) return;
  if (const int flags = fcntl(descriptor, F_GETFD); flags >= 0) fcntl(descriptor, F_SETFD, flags | FD_CLOEXEC);
  const std::scoped_lock lock(kept().mutex);
  kept().numbers.push_back(descriptor);
}

bool forget_descriptor(int descriptor) {
  const std::scoped_lock lock(kept().mutex);
  std::vector<int>& numbers = kept().numbers;
  const auto found = std::find(numbers.begin(), numbers.end(), descriptor);
  if (found == numbers.end()) return false;
  numbers.erase(found);
  return true;
}

void close_kept(int descriptor) {
  const NoFork until_closed;
  if (forget_descriptor(descriptor)) ::close(descriptor);
}

}  // namespace tactor
