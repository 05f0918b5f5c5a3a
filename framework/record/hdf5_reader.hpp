// Reads recordings from HDF5 files, finished ones and those a killed or running process left.
#pragma once

#include "framework/core/read_budget.hpp"
#include "framework/record/hdf5_layout.hpp"
#include "framework/record/packed_layout.hpp"
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
  void read(std::size_t stream, std::uint64_t first, std::uint64_t count, MessageBatch& out) override;

 private:
  /// A dataset of rows.
  struct Rows {
    Handle data;
    Handle memory_type;  // of a row
    std::size_t row_bytes = 0;
    std::uint64_t count = 0;
    std::uint64_t chunk_rows = 0;  // 0: it has no chunks
  };
  /// A field that changes size.
  struct ArrayRows {
    Rows rows;
    PackedLayout element;
    std::size_t stride = 0;  // bytes of an element in memory
  };
  struct Stream {
    Rows messages;
    PackedLayout layout;
    std::vector<ArrayRows> arrays;
    bool has_enumerations = false;
  };

  [[noreturn]] void refuse(const std::string& why) const;
  void read_header();
  void add_stream(hid_t group, const std::string& name);
  Rows open_rows(hid_t group, const std::string& path, const std::string& stream, Handle file_type,
                 Handle memory_type) const;
  /// The messages whose arrays are all there: a run that was killed may leave some at the end whose are not.
  std::uint64_t whole_messages(const std::string& name, const Stream& stream);
  void read_rows(const std::string& name, const Rows& rows, std::uint64_t first, std::uint64_t count,
                 std::vector<std::byte>& bytes) const;
  SharedBytes read_array(const std::string& name, const ArrayRows& array, std::uint64_t first, std::uint64_t count,
                         ReadBudget& budget) const;
  /// Charges bytes for a stream to the budget.
  void take(ReadBudget& budget, const std::string& name, std::uint64_t count, std::uint64_t bytes_each) const;

  std::filesystem::path path_;
  Handle file_;
  RecordingHeader header_;
  bool complete_ = false;
  std::vector<RecordedStream> streams_;
  std::vector<Stream> open_;
  std::vector<std::byte> bytes_;
};

/// `RecordLibrary::repair`.
void repair_recording(const std::filesystem::path& path);

}  // namespace tactor
