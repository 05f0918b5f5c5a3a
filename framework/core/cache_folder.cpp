#include "framework/core/cache_folder.hpp"

#include <cstdlib>

namespace tactor {

namespace fs = std::filesystem;

fs::path default_cache_folder() {
  if (const char* folder = std::getenv("TACTOR_CACHE")) return folder;
  if (const char* folder = std::getenv("XDG_CACHE_HOME")) return fs::path(folder) / "tactor";
  if (const char* home = std::getenv("HOME")) return fs::path(home) / ".cache" / "tactor";
  return fs::temp_directory_path() / "tactor-cache";
}

}  // namespace tactor
