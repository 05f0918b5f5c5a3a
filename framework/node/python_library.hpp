// What the library libtactor_python.so gives: the declarations of nodes that are classes in Python files.
#pragma once

#include <filesystem>
#include <string>

#include "framework/node/info.hpp"

namespace tactor {

class Registry;

inline constexpr const char* python_library_file = "libtactor_python.so";
inline constexpr const char* python_library_entry = "tactor_python_library";

/// Loaded by a graph that names such a class, so that no other run loads Python.
struct PythonLibrary {
  /// See Registry::find_python; `registry` loads the libraries of the message types that the class names.
  const NodeInfo& (*declare)(const std::filesystem::path& file, const std::string& name, Registry& registry);
};

}  // namespace tactor
