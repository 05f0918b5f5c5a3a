#include "python/nodes/node_code.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <utility>

#include "python/file_text.hpp"
#include "python/nodes/interpreter.hpp"

namespace tactor::python {

namespace py = pybind11;

namespace {

thread_local int depth = 0;  // of code of nodes on this thread
// With the interpreter's lock:
pid_t running_process = 0;  // in which code of a node ran last
std::optional<std::string> asked_to_end;

/// Raises SystemExit, which `except Exception` lets pass.
[[noreturn]] void refuse(const std::string& call) {
  const std::string why = call +
                          " in the code of a node would end the process that runs the graph, without a ramp to zero; "
                          "raise an exception to end the run";
  asked_to_end =
      why + "\n" + bytes_of_text(py::str("").attr("join")(py::module_::import("traceback").attr("format_stack")()));
  while (asked_to_end->ends_with('\n')) asked_to_end->pop_back();
  PyErr_SetString(PyExc_SystemExit, why.c_str());
  throw py::error_already_set();
}

/// Puts functions that look first in the place of those that end a process.
void keep_process_alive() {
  const py::module_ os = py::module_::import("os"), posix = py::module_::import("posix");
  for (const char* name : {"_exit", "abort", "execv", "execve"}) {
    const py::object real = os.attr(name);
    const py::cpp_function looks(
        [real, call = std::string("os.") + name](const py::args& args, const py::kwargs& kwargs) -> py::object {
          if ((depth > 0 || is_own_interpreter()) && getpid() == running_process) refuse(call);
          return real(*args, **kwargs);
        },
        py::name(name), py::doc("As ever, but not in the code of a node of Tactor, whose run it ends instead."));
    os.attr(name) = looks;
    posix.attr(name) = looks;
  }
}

}  // namespace

NodeCode::NodeCode() : process_(getpid()) {
  running_process = process_;
  ++depth;
  // Guarded by the interpreter's lock.
  static bool kept = false;
  if (!std::exchange(kept, true)) keep_process_alive();
}

NodeCode::~NodeCode() {
  --depth;
}

void NodeCode::end_child(py::error_already_set* error) const {
  if (getpid() == process_) return;
  int code = 0;
  if (error != nullptr) {
    error->restore();
    code = 1;
    if (PyErr_ExceptionMatches(PyExc_SystemExit) != 0) {
      const py::error_already_set ending;
      const py::object asked = ending.value().attr("code");
      if (py::isinstance<py::int_>(asked)) code = asked.cast<int>() & 0xff;
      if (asked.is_none()) code = 0;
    } else {
      PyErr_Print();
    }
  }
  _exit(code);
}

std::optional<std::string> NodeCode::kept_alive() {
  return std::exchange(asked_to_end, std::nullopt);
}

}  // namespace tactor::python
