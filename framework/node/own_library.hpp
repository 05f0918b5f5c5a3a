// Finds and loads a library that belongs to this program and is loaded by runs that need it.
#pragma once

#include <filesystem>
#include <string>

namespace tactor {

/// Loads `file_name` from the folder of the program, ../lib or the folder of the framework's library, and returns the
/// address of `symbol` in it. It stays loaded until the process ends. Throws InputError, beginning with `without`,
/// where it is not there, and where it belongs to another build.
void* load_from_own_library(const std::string& file_name, const char* symbol, const std::string& without);

}  // namespace tactor
