#include "framework/core/installation.hpp"

#include <dlfcn.h>

#include <system_error>

#include "framework/core/check.hpp"

namespace tactor {

namespace fs = std::filesystem;

const fs::path& library_folder() {
  static const fs::path folder = [] {
    Dl_info info{};
    TACTOR_DEMAND(dladdr(reinterpret_cast<const void*>(&library_folder), &info) != 0 && info.dli_fname != nullptr);
    // /lib may be a link to /usr/lib, and then only the latter leads to the prefix.
    std::error_code error;
    const fs::path file = fs::canonical(info.dli_fname, error);
    return (error ? fs::absolute(info.dli_fname) : file).parent_path();
  }();
  return folder;
}

const fs::path& installation_prefix() {
  static const fs::path prefix = [] {
    fs::path folder = library_folder();
    // Takes lib or lib/x86_64-linux-gnu off, word by word.
    for (fs::path part = fs::path(TACTOR_LIBDIR).lexically_normal(); !part.empty(); part = part.parent_path()) {
      folder = folder.parent_path();
    }
    return folder;
  }();
  return prefix;
}

}  // namespace tactor
