// Finds and loads the recording library, so that a run without recordings never loads HDF5.
#include <dlfcn.h>

#include <array>

#include "framework/core/check.hpp"
#include "framework/core/messages.hpp"
#include "framework/record/recorder.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

constexpr const char* file_name = "libtactor_record.so";

fs::path framework_folder() {
  Dl_info info{};
  const auto* symbol = reinterpret_cast<const void*>(&find_message_type);
  if (dladdr(symbol, &info) == 0 || info.dli_fname == nullptr) return {};
  return fs::path(info.dli_fname).parent_path();
}

const RecordLibrary& load() {
  const fs::path program = fs::read_symlink("/proc/self/exe").parent_path();
  std::string searched;
  for (const fs::path& folder : std::array{program, program.parent_path() / "lib", framework_folder()}) {
    const fs::path file = folder / file_name;
    if (folder.empty() || !fs::exists(file)) {
      searched.append(searched.empty() ? "" : ", ").append(folder.string());
      continue;
    }
    void* handle = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (handle == nullptr) throw InputError("cannot load the recording library: " + std::string(dlerror()));
    const auto entry = reinterpret_cast<decltype(&tactor_record_library)>(dlsym(handle, "tactor_record_library"));
    const RecordLibrary* library = entry == nullptr ? nullptr : entry(TACTOR_RECORD_ABI);
    if (library == nullptr) throw InputError(file.string() + " belongs to another build of tactor; build it again");
    return *library;
  }
  throw InputError("this build has no HDF5, so it can neither record nor replay .h5 files: " + std::string(file_name) +
                   " is not in " + searched +
                   "; configure with -DTACTOR_WITH_HDF5=ON, or leave the recording out of the graph");
}

}  // namespace

const RecordLibrary& load_record_library() {
  static const RecordLibrary& library = load();
  return library;
}

std::size_t RecordingReader::find(std::string_view name) const {
  std::string there;
  for (std::size_t i = 0; i < streams().size(); ++i) {
    if (streams()[i].name == name) return i;
    there.append(there.empty() ? "" : ", ").append(streams()[i].name);
  }
  throw InputError(path().string() + " has no stream '" + std::string(name) +
                   "'; it has: " + (there.empty() ? "none" : there));
}

}  // namespace tactor
