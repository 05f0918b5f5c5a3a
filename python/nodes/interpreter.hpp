// The Python interpreter that nodes run in: that of the process, or one that this library starts.
#pragma once

#include <pybind11/pybind11.h>

#include <string>

namespace tactor::python {

/// Starts an interpreter where the process has none, once; it lives until the process ends, and its lock is free
/// afterwards. It takes no signals but a second Ctrl-C, changes no locale, writes what nodes print to the error output,
/// and hashes texts without a seed, so that the order of a set is the same in every run. Throws InputError where Python
/// cannot start.
void start_interpreter();

/// True where this library has started the interpreter, because the process had none.
bool is_own_interpreter();

/// The module tactor._node_class. With the interpreter's lock. Throws InputError where the package is not there.
pybind11::module_ node_module();

/// The error with its traceback, as Python prints them. With the interpreter's lock.
std::string traceback_of(const pybind11::error_already_set& error);

}  // namespace tactor::python
