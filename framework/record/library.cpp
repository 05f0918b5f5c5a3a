// Finds and loads the recording library, so that a run without recordings never loads HDF5.
#include "framework/core/check.hpp"
#include "framework/node/plugin.hpp"
#include "framework/record/recorder.hpp"

namespace tactor {

const RecordLibrary& load_record_library() {
  static const RecordLibrary& library = load_plugin<RecordLibrary>(
      "libtactor_record.so", "tactor_record_library",
      "this build has no HDF5, so it can neither record nor replay .h5 files (configure with -DTACTOR_WITH_HDF5=ON, or "
      "leave the recording out of the graph)");
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
