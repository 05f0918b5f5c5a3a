#include "framework/node/plugin.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <system_error>

#include "framework/core/check.hpp"
#include "framework/core/installation.hpp"
#include "framework/node/abi.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

fs::path plugin_folder() {
  return library_folder() / "tactor" / "plugins";
}

}  // namespace

bool has_plugin(const std::string& file_name) {
  return fs::exists(plugin_folder() / file_name);
}

std::vector<fs::path> plugin_files() {
  std::vector<fs::path> files;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(plugin_folder(), ignored)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("libtactor_") && name.ends_with(".so")) files.push_back(fs::canonical(entry.path(), ignored));
  }
  std::sort(files.begin(), files.end());
  return files;
}

void* load_plugin_symbol(const std::string& file_name, const char* symbol, const std::string& without) {
  const fs::path file = plugin_folder() / file_name;
  if (!fs::exists(file)) throw InputError(without + ": " + file_name + " is not in " + plugin_folder().string());
  check_abi(file);
  void* handle = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr) throw InputError("cannot load " + file.string() + ": " + std::string(dlerror()));
  void* address = dlsym(handle, symbol);
  if (address == nullptr) throw InputError(file.string() + ": expected the function " + symbol + ", found none");
  return address;
}

}  // namespace tactor
