// The entry of libtactor_record.so.
#include "framework/node/abi.hpp"
#include "framework/record/hdf5_reader.hpp"
#include "framework/record/hdf5_table.hpp"
#include "framework/record/hdf5_writer.hpp"
#include "framework/record/recorder.hpp"
#include "tactor_abi.hpp"

namespace {

using namespace tactor;

constexpr RecordLibrary library{
    .create = [](const std::filesystem::path& path, const RecordingHeader& header) -> std::unique_ptr<Recorder> {
      return std::make_unique<Hdf5Recorder>(path, header);
    },
    .open = [](const std::filesystem::path& path) -> std::unique_ptr<RecordingReader> {
      return std::make_unique<Hdf5Reader>(path);
    },
    .repair = repair_recording,
    .write_table = write_hdf5_table,
};

}  // namespace

TACTOR_STATES_ABI;

extern "C" __attribute__((visibility("default"))) const tactor::RecordLibrary* tactor_record_library() {
  return &library;
}
