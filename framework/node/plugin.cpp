#include "framework/node/plugin.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <array>
#include <system_error>

#include "framework/core/check.hpp"
#include "framework/core/installation.hpp"
#include "framework/node/abi.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

/// Where libraries of this installation are looked for.
std::array<fs::path, 2> library_folders() {
  return {library_folder(), library_folder() / "tactor" / "plugins"};
}

}  // namespace

bool has_plugin(const std::string& file_name) {
  const std::array<fs::path, 2> folders = library_folders();
  return std::any_of(folders.begin(), folders.end(),
                     [&](const fs::path& folder) { return fs::exists(folder / file_name); });
}

std::vector<fs::path> plugin_files() {
  std::vector<fs::path> files;
  for (const fs::path& folder : library_folders()) {
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(folder, ignored)) {
      const std::string name = entry.path().filename().string();
      if (name.starts_with("libtactor_") && name.ends_with(".so"))
        files.push_back(fs::canonical(entry.path(), ignored));
    }
  }
  std::sort(files.begin(), files.end());
  files.erase(std::unique(files.begin(), files.end()), files.end());
  return files;
}

void* load_plugin_symbol(const std::string& file_name, const char* symbol, const std::string& without) {
  std::string searched;
  for (const fs::path& folder : library_folders()) {
    const fs::path file = folder / file_name;
    if (!fs::exists(file)) {
      searched.append(searched.empty() ? "" : ", ").append(folder.string());
      continue;
    }
    check_abi(file);
    void* handle = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (handle == nullptr) throw InputError("cannot load " + file.string() + ": " + std::string(dlerror()));
    void* address = dlsym(handle, symbol);
    if (address == nullptr) throw InputError(file.string() + ": expected the function " + symbol + ", found none");
    return address;
  }
  throw InputError(without + ": " + file_name + " is not in " + searched);
}

}  // namespace tactor
