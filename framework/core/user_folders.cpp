#include "framework/core/user_folders.hpp"

#include <pwd.h>
#include <unistd.h>

#include <cstdlib>
#include <vector>

namespace tactor {

namespace fs = std::filesystem;

namespace {

/// The absolute path that a variable holds; empty where it holds none.
fs::path said(const char* name) {
  const char* value = std::getenv(name);
  return value != nullptr && value[0] == '/' ? fs::path(value) : fs::path();
}

fs::path home() {
  if (fs::path folder = said("HOME"); !folder.empty()) return folder;
  std::vector<char> texts(1 << 14);
  passwd entry{};
  passwd* found = nullptr;
  if (getpwuid_r(geteuid(), &entry, texts.data(), texts.size(), &found) != 0 || found == nullptr) return {};
  // Users without a home have a folder there that does not exist.
  std::error_code error;
  return found->pw_dir != nullptr && found->pw_dir[0] == '/' && fs::is_directory(found->pw_dir, error)
             ? fs::path(found->pw_dir)
             : fs::path();
}

fs::path ours_in(const char* variable, const char* below_home) {
  if (const fs::path folder = said(variable); !folder.empty()) return folder / "tactor";
  const fs::path folder = home();
  return folder.empty() ? folder : folder / below_home / "tactor";
}

}  // namespace

fs::path default_cache_folder() {
  if (const char* value = std::getenv("TACTOR_CACHE"); value != nullptr && value[0] != '\0') return fs::absolute(value);
  return ours_in("XDG_CACHE_HOME", ".cache");
}

fs::path state_folder() {
  return ours_in("XDG_STATE_HOME", ".local/state");
}

fs::path user_data_folder() {
  return ours_in("XDG_DATA_HOME", ".local/share");
}

fs::path runtime_folder() {
  if (const fs::path folder = said("XDG_RUNTIME_DIR"); !folder.empty()) return folder / "tactor";
  return state_folder();
}

}  // namespace tactor
