// What keeps the code of a node from ending the process that drives devices, as far as that can be done.
#pragma once

#include <pybind11/pybind11.h>
#include <sys/types.h>

#include <optional>
#include <string>

namespace tactor::python {

/// Code of nodes runs on the calling thread while it lives. Made with the interpreter's lock.
///
/// os._exit, os.abort, os.execv and os.execve (under all the names that os makes of it) do not end the process then:
/// they raise SystemExit. In an interpreter of our own they never do, on no thread. In a child that the code has forked
/// they are what they were.
class NodeCode {
 public:
  NodeCode();
  NodeCode(const NodeCode&) = delete;
  NodeCode& operator=(const NodeCode&) = delete;
  ~NodeCode();

  /// In a child that the code has forked: ends it, because it must not go on as the run; `error` is what the code has
  /// raised, or null. Elsewhere nothing happens.
  void end_child(pybind11::error_already_set* error) const;
  /// Which call was kept from ending the process since the last question, and where; none where there was none.
  static std::optional<std::string> kept_alive();

 private:
  pid_t process_;
};

}  // namespace tactor::python
