// Reads recordings from HDF5 files, finished ones and those a killed or running process left.
#pragma once

#include "framework/record/hdf5_layout.hpp"
#include "framework/record/recorder.hpp"

namespace tactor {

/// The reader of `RecordLibrary::open`.
class Hdf5Reader final : public RecordingReader {
 public:
  explicit Hdf5Reader(std::filesystem::path path);

  [[nodiscard]] const std::filesystem::path& path() const override { return path_; }
  [[nodiscard]] const RecordingHeader& header() const override { return header_; }
  [[nodiscard]] bool complete() const override { return complete_; }
  [[nodiscard]] const std::vector<RecordedStream>& streams() const override { return streams_; }
  void read(std::size_t stream, std::uint64_t first, std::uint64_t count, std::vector<Stamp>& stamps,
            std::vector<std::byte>& payloads) override;

 private:
  [[noreturn]] void refuse(const std::string& why) const;
  void read_header();
  void add_stream(hid_t group, const std::string& name);

  std::filesystem::path path_;
  Handle file_;
  RecordingHeader header_;
  bool complete_ = false;
  std::vector<RecordedStream> streams_;
  std::vector<Handle> data_;
  std::vector<std::byte> records_;
};

/// `RecordLibrary::repair`.
void repair_recording(const std::filesystem::path& path);

}  // namespace tactor
