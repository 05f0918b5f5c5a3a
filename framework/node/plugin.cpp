#include "framework/node/plugin.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <array>
#include <system_error>

#include "framework/core/check.hpp"
#include "tactor_abi.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

fs::path framework_folder() {
  Dl_info info{};
  const auto* symbol = reinterpret_cast<const void*>(&program_abi);
  if (dladdr(symbol, &info) == 0 || info.dli_fname == nullptr) return {};
  return fs::path(info.dli_fname).parent_path();
}

/// Where libraries of this program are looked for.
std::array<fs::path, 3> library_folders() {
  const fs::path program = fs::read_symlink("/proc/self/exe").parent_path();
  return {program, program.parent_path() / "lib", framework_folder()};
}

}  // namespace

std::uint64_t program_abi() {
  return TACTOR_ABI;
}

bool has_plugin(const std::string& file_name) {
  const std::array<fs::path, 3> folders = library_folders();
  return std::any_of(folders.begin(), folders.end(),
                     [&](const fs::path& folder) { return !folder.empty() && fs::exists(folder / file_name); });
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
    if (folder.empty() || !fs::exists(file)) {
      searched.append(searched.empty() ? "" : ", ").append(folder.string());
      continue;
    }
    void* handle = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (handle == nullptr) throw InputError("cannot load " + file.string() + ": " + std::string(dlerror()));
    void* address = dlsym(handle, symbol);
    if (address == nullptr) throw InputError(file.string() + " belongs to another build of tactor; build it again");
    return address;
  }
  throw InputError(without + ": " + file_name + " is not in " + searched);
}

}  // namespace tactor
