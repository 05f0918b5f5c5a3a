// The interpreter's lock, for threads that may still be at work when the interpreter ends.
#pragma once

#include <pybind11/pybind11.h>

#include <cxxabi.h>
#include <unistd.h>

namespace tactor::python {

/// The thread stays here until the process ends. Python ends a thread that asks for the lock of an interpreter that
/// ends, and does that through all frames of the thread; those of C++ would end the process.
[[noreturn]] inline void park() {
  for (;;) pause();
}

/// Calls `work`, which may take the interpreter's lock again, and parks the thread where the interpreter has ended.
template <class Work>
auto parked_at_end(const Work& work) {
  try {
    return work();
  } catch (const abi::__forced_unwind&) {
    park();
  }
}

/// Lets other threads have the lock while it lives.
class LockReleased {
 public:
  LockReleased() : state_(PyEval_SaveThread()) {}
  LockReleased(const LockReleased&) = delete;
  LockReleased& operator=(const LockReleased&) = delete;
  ~LockReleased() {
    parked_at_end([this] { PyEval_RestoreThread(state_); });
  }

 private:
  PyThreadState* state_;
};

/// Holds the lock while it lives, on any thread.
class LockHeld {
 public:
  LockHeld() {
    // A thread that Python does not know has no place in an interpreter that ends.
    if ((Py_IsInitialized() == 0 || is_ending()) && PyGILState_GetThisThreadState() == nullptr) park();
    state_ = parked_at_end([] { return PyGILState_Ensure(); });
  }
  LockHeld(const LockHeld&) = delete;
  LockHeld& operator=(const LockHeld&) = delete;
  ~LockHeld() { PyGILState_Release(state_); }

 private:
  static bool is_ending() {
#if PY_VERSION_HEX >= 0x030d0000
    return Py_IsFinalizing() != 0;
#else
    return _Py_IsFinalizing() != 0;
#endif
  }

  PyGILState_STATE state_;
};

}  // namespace tactor::python
