// The entry of libtactor_python.so, which a graph loads that names a class of a Python file.
#include "framework/node/abi.hpp"
#include "framework/node/python_library.hpp"
#include "python/nodes/node_class.hpp"
#include "tactor_abi.hpp"

TACTOR_STATES_ABI;

extern "C" __attribute__((visibility("default"))) const tactor::PythonLibrary* tactor_python_library() {
  static constexpr tactor::PythonLibrary library{&tactor::python::declare};
  return &library;
}
