// libtactor_python.so: loaded by a graph that names a class of a Python file.
#include "framework/node/python_library.hpp"
#include "python/nodes/node_class.hpp"
#include "tactor_abi.hpp"

extern "C" __attribute__((visibility("default"))) const tactor::PythonLibrary* tactor_python_library(
    std::uint64_t abi) {
  static const tactor::PythonLibrary library{&tactor::python::declare};
  return abi == TACTOR_ABI ? &library : nullptr;
}
