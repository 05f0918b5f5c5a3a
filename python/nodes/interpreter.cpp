#include "python/nodes/interpreter.hpp"

#include <dlfcn.h>

#include <array>
#include <filesystem>
#include <mutex>

#include "framework/core/check.hpp"
#include "framework/core/installation.hpp"

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
  for (const char* place : {"python", "lib/python3/dist-packages"}) {
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

void add_package_folder() {
  const fs::path folder = package_folder();
  if (folder.empty()) return;
  py::list path = py::module_::import("sys").attr("path");
  if (!path.contains(folder.string())) path.insert(0, folder.string());
}

}  // namespace

void start_interpreter() {
  static std::once_flag once;
  std::call_once(once, [] {
    if (Py_IsInitialized() != 0) return;
    configure_and_start();
    add_package_folder();
    const py::module_ sys = py::module_::import("sys");
    sys.attr("stdout") = sys.attr("stderr");
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
    std::string text = py::str("").attr("join")(lines).cast<std::string>();
    while (text.ends_with('\n')) text.pop_back();
    return text;
  } catch (const py::error_already_set&) {
    return error.what();
  }
}

}  // namespace tactor::python
