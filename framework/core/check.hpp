// Three levels of check: bad user input throws, a bug of ours aborts, hot paths assert in debug builds only.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>

namespace tactor {

/// The user's input (graph, mesh, recording, option) cannot be used. The message names the place, what was expected,
/// what was found and the remedy. The command ends with exit code 2.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Something other than bad input failed during a run (a disk, a process). The command ends with exit code 1.
class RunError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

[[noreturn]] inline void broken_belief(const char* what, const char* file, int line) {
  std::fprintf(stderr, "%s:%d: broken belief: %s\n", file, line, what);
  std::abort();
}

}  // namespace tactor

/// A condition that holds unless the program itself is wrong; checked in every build.
#define TACTOR_DEMAND(condition) \
  ((condition) ? static_cast<void>(0) : ::tactor::broken_belief(#condition, __FILE__, __LINE__))

/// The same for hot paths; checked in debug builds only.
#ifdef NDEBUG
#define TACTOR_ASSERT(condition) static_cast<void>(0)
#else
#define TACTOR_ASSERT(condition) TACTOR_DEMAND(condition)
#endif
