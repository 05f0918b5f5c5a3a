#include "framework/core/cache_folder.hpp"

#include <cstdlib>
#include <string_view>

namespace tactor {

namespace fs = std::filesystem;

fs::path default_cache_folder() {
  const auto said = [](const char* name) -> std::string_view {
    const char* value = std::getenv(name);
    return value == nullptr ? "" : value;
  };
  if (const auto folder = said("TACTOR_CACHE"); !folder.empty()) return folder;
  if (const auto folder = said("XDG_CACHE_HOME"); !folder.empty()) return fs::path(folder) / "tactor";
  if (const auto home = said("HOME"); !home.empty()) return fs::path(home) / ".cache" / "tactor";
  return fs::temp_directory_path() / "tactor-cache";
}

}  // namespace tactor
