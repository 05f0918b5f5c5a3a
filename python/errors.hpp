// Errors of the framework as exceptions of the package, and signals while a call into the framework goes on.
#pragma once

#include <pybind11/pybind11.h>

namespace tactor::python {

/// From now on InputError, YamlError and RunError are tactor.InputError and tactor.RunError in Python.
void translate_errors();

/// Runs the handlers of signals that have come, on Python's main thread; throws what they raise: KeyboardInterrupt for
/// Ctrl-C. With the interpreter's lock.
inline void check_signals() {
  if (PyErr_CheckSignals() != 0) throw pybind11::error_already_set();
}

}  // namespace tactor::python
