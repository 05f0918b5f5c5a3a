// Finds and loads a library that belongs to this program and is loaded by runs that need it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "framework/core/check.hpp"

namespace tactor {

/// Whether such a library is installed; does not load it.
bool has_plugin(const std::string& file_name);

/// All libraries that lie where those of this program are looked for, loaded or not, in order of their paths.
std::vector<std::filesystem::path> plugin_files();

/// Loads `file_name` from the folder of the program, ../lib or the folder of the framework's library, and returns the
/// address of `symbol` in it. It stays loaded until the process ends. Throws InputError, beginning with `without`,
/// where it is not there, and where it belongs to another build.
void* load_plugin_symbol(const std::string& file_name, const char* symbol, const std::string& without);

/// A number that libraries and program share, over the headers that they were compiled with (see
/// cmake/TactorAbi.cmake).
std::uint64_t program_abi();

/// The functions `Library` that `entry` of such a library returns. Throws InputError too where it was compiled with
/// other headers.
template <class Library>
const Library& load_plugin(const std::string& file_name, const char* entry, const std::string& without) {
  const auto ask = reinterpret_cast<const Library* (*)(std::uint64_t)>(load_plugin_symbol(file_name, entry, without));
  const Library* library = ask(program_abi());
  if (library == nullptr) throw InputError(file_name + " belongs to another build of tactor; build it again");
  return *library;
}

}  // namespace tactor
