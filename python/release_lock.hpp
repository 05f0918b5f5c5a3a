// Work of the framework while other threads of Python go on.
#pragma once

#include <pybind11/pybind11.h>

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>

#include "framework/core/time.hpp"
#include "python/ending.hpp"
#include "python/interpreter_lock.hpp"

namespace tactor::python {

/// What `task` returns, which it computes without the interpreter's lock. `live`: see Work.
template <class Task>
auto without_lock(const Task& task, bool live = false) {
  const LockReleased released;
  const Work work(live);
  return task();
}

/// A lock that is given in the order in which it is asked for, so that who takes it again and again keeps nobody out.
class TurnLock {
 public:
  void lock() {
    std::unique_lock lock(mutex_);
    const std::uint64_t turn = next_++;
    changed_.wait(lock, [&] { return serving_ == turn; });
  }
  void unlock() {
    {
      const std::scoped_lock lock(mutex_);
      ++serving_;
    }
    changed_.notify_all();
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::uint64_t next_ = 0, serving_ = 0;
};

/// A span of time from Python: a number in seconds, or a text with its unit (`10 ms`). Throws InputError, with `what`
/// in front, where it is neither, or not in [0, 1e9 s].
Duration duration_of(const pybind11::object& given, const std::string& what);

}  // namespace tactor::python
