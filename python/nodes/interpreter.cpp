#include "python/nodes/interpreter.hpp"

#include <dlfcn.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <mutex>

#include "framework/core/check.hpp"
#include "framework/core/installation.hpp"
#include "python/file_text.hpp"

namespace tactor::python {

namespace fs = std::filesystem;
namespace py = pybind11;

namespace {

/// The file that holds what is at `address`.
fs::path file_of(const void* address) {
  Dl_info info{};
  if (dladdr(address, &info) == 0 || info.dli_fname == nullptr) return {};
  std::error_code ignored;
  return fs::canonical(info.dli_fname, ignored);
}

/// The folder that holds the package tactor of this build or installation. Empty where it is not there; then it has to
/// be on Python's own path.
fs::path package_folder() {
  for (const char* place : {"python", TACTOR_PYTHON_PACKAGES}) {
    const fs::path folder = installation_prefix() / place;
    if (fs::exists(folder / "tactor" / "_node_class.py")) return folder;
  }
  return {};
}

void demand(const PyStatus& status) {
  if (PyStatus_Exception(status) == 0) return;
  throw InputError(std::string("Python cannot start: ") + (status.err_msg != nullptr ? status.err_msg : "no reason") +
                   "; install python3 and python3-numpy");
}

void configure_and_start() {
  // Modules in C find Python's own symbols among those that all libraries see.
  const fs::path python = file_of(reinterpret_cast<const void*>(&Py_InitializeFromConfig));
  dlopen(python.c_str(), RTLD_NOW | RTLD_NOLOAD | RTLD_GLOBAL);

  PyPreConfig before;
  PyPreConfig_InitPythonConfig(&before);
  before.configure_locale = 0;
  before.coerce_c_locale = 0;
  before.utf8_mode = 1;
  before.parse_argv = 0;
  demand(Py_PreInitialize(&before));

  PyConfig config;
  PyConfig_InitPythonConfig(&config);
  config.parse_argv = 0;
  config.install_signal_handlers = 0;
  config.buffered_stdio = 0;
  config.use_hash_seed = 1;
  config.hash_seed = 0;
  // Python looks for its modules from where this program would be.
  PyStatus status = PyConfig_SetBytesString(&config, &config.program_name, TACTOR_PYTHON_PROGRAM);
  if (PyStatus_Exception(status) == 0) status = Py_InitializeFromConfig(&config);
  PyConfig_Clear(&config);
  demand(status);
}

std::atomic<bool> started_here = false;
std::atomic<int> times_asked = 0;
void (*ask_first)(int) = nullptr;

/// The program's own handler hears it always; Python the second time, when a step did not come back.
void ask(int number) {
  ask_first(number);
  if (++times_asked >= 2) PyErr_SetInterrupt();
}

/// Ctrl-C again raises KeyboardInterrupt in the code of a node that does not come back, where the program listens to
/// the first one.
void listen_for_second_interrupt() {
  struct sigaction before {};
  sigaction(SIGINT, nullptr, &before);
  if ((before.sa_flags & SA_SIGINFO) != 0 || before.sa_handler == SIG_DFL || before.sa_handler == SIG_IGN) return;
  ask_first = before.sa_handler;
  const py::module_ signal = py::module_::import("signal");
  // This puts Python's handler in place of the program's.
  signal.attr("signal")(SIGINT, signal.attr("default_int_handler"));
  before.sa_handler = ask;
  sigaction(SIGINT, &before, nullptr);
}

/// What Python takes for its error output: the stream of this program, which shows only text and has no file that
/// Python could open by itself.
py::object error_output() {
  const py::object base = py::module_::import("io").attr("TextIOBase");
  py::dict members;
  members["write"] = py::cpp_function(
      [](const py::object& /*self*/, const py::str& text) {
        const std::string bytes = bytes_of_text(text);
        static_cast<void>(std::fwrite(bytes.data(), 1, bytes.size(), stderr));
        static_cast<void>(std::fflush(stderr));
        return py::len(text);
      },
      py::is_method(base));
  // For programs that the code of a node starts.
  members["fileno"] = py::cpp_function([](const py::object& /*self*/) { return STDERR_FILENO; }, py::is_method(base));
  return py::module_::import("builtins").attr("type")("ErrorOutput", py::make_tuple(base), members)();
}

void add_package_folder() {
  const fs::path folder = package_folder();
  if (folder.empty()) return;
  py::list path = py::module_::import("sys").attr("path");
  const py::str text = python_text(folder.native());
  if (!path.contains(text)) path.insert(0, text);
}

}  // namespace

bool is_own_interpreter() {
  return started_here;
}

void start_interpreter() {
  static std::once_flag once;
  std::call_once(once, [] {
    if (Py_IsInitialized() != 0) return;
    configure_and_start();
    started_here = true;
    add_package_folder();
    listen_for_second_interrupt();
    const py::module_ sys = py::module_::import("sys");
    for (const char* stream : {"stderr", "stdout"}) sys.attr(stream) = error_output();
    // Whoever calls into Python takes the lock.
    PyEval_SaveThread();
  });
}

py::module_ node_module() {
  try {
    return py::module_::import("tactor._node_class");
  } catch (const py::error_already_set& error) {
    throw InputError("nodes in Python need the package tactor, and Python refuses it: " + traceback_of(error));
  }
}

std::string traceback_of(const py::error_already_set& error) {
  try {
    const py::object lines =
        py::module_::import("traceback").attr("format_exception")(error.type(), error.value(), error.trace());
    std::string text = bytes_of_text(py::str("").attr("join")(lines));
    while (text.ends_with('\n')) text.pop_back();
    return text;
  } catch (const py::error_already_set&) {
    return error.what();
  }
}

}  // namespace tactor::python
