// Finds and loads a library that belongs to this program and is loaded by runs that need it.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "framework/core/check.hpp"

namespace tactor {

/// Whether such a library is installed; does not load it.
bool has_plugin(const std::string& file_name);

/// All plugins of this program, loaded or not, in the order of their paths.
std::vector<std::filesystem::path> plugin_files();

/// Loads `file_name` from tactor/plugins in the folder of libtactor, and returns the address of `symbol` in it.
/// It stays loaded until the process ends. Throws InputError, beginning with `without`, if it is missing, and like
/// check_abi if it belongs to another build.
void* load_plugin_symbol(const std::string& file_name, const char* symbol, const std::string& without);

/// The struct `Library` of functions that `entry` of such a library returns. Its arguments are no references: GCC 13
/// and newer would take the result for a reference to a temporary argument, and warn.
template <class Library>
const Library& load_plugin(std::string_view file_name, const char* entry, std::string_view without) {
  const auto ask =
      reinterpret_cast<const Library* (*)()>(load_plugin_symbol(std::string(file_name), entry, std::string(without)));
  return *ask();
}

}  // namespace tactor
