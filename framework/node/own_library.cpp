#include "framework/node/own_library.hpp"

#include <dlfcn.h>

#include <array>

#include "framework/core/check.hpp"
#include "framework/core/messages.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

fs::path framework_folder() {
  Dl_info info{};
  const auto* symbol = reinterpret_cast<const void*>(&find_message_type);
  if (dladdr(symbol, &info) == 0 || info.dli_fname == nullptr) return {};
  return fs::path(info.dli_fname).parent_path();
}

}  // namespace

void* load_from_own_library(const std::string& file_name, const char* symbol, const std::string& without) {
  const fs::path program = fs::read_symlink("/proc/self/exe").parent_path();
  std::string searched;
  for (const fs::path& folder : std::array{program, program.parent_path() / "lib", framework_folder()}) {
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
