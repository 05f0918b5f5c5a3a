// Writes recordings as HDF5: readable by others while the run lasts, compressed and reproducible once closed.
#pragma once

#include <chrono>
#include <filesystem>
#include <string>

#include "framework/core/file_descriptor.hpp"
#include "framework/core/write_lock.hpp"
#include "framework/record/hdf5_layout.hpp"
#include "framework/record/packed_layout.hpp"
#include "framework/record/recorder.hpp"

namespace tactor {

/// The lock that a running recorder holds on its file.
class RecordingLock {
 public:
  /// Opens the file, which has to be there unless `make`, and takes its lock. Throws InputError, with `doing` before
  /// the reason, where it cannot be written or another program writes it.
  RecordingLock(const std::filesystem::path& path, bool make, const std::string& doing);
  /// The open file.
  [[nodiscard]] int file() const { return file_.number(); }

 private:
  FileDescriptor file_;
  WriteLock lock_;
};

/// Whether another program writes the file now, in any way.
bool is_being_written(const std::filesystem::path& path);

/// The recorder of `RecordLibrary::create`.
///
/// While the run lasts the file is in HDF5's single-writer/multiple-reader mode, in which every state of the file on
/// disk is readable. Flushes follow the wall clock and so leave traces in that file's layout; `close` therefore copies
/// the streams, chunk by chunk, to a second file and moves it over the first.
class Hdf5Recorder final : public Recorder {
 public:
  Hdf5Recorder(std::filesystem::path path, RecordingHeader header);
  ~Hdf5Recorder() override;

  std::size_t add_stream(std::string_view name, const MessageType& type) override;
  void write(std::size_t stream, const Stamp& stamp, const void* payload) override;
  void flush() override;
  void close() override;

 private:
  /// A dataset to which rows are appended.
  struct Rows {
    std::string path;               // in the file
    Handle file_type, memory_type;  // of a row
    std::size_t row_bytes = 0;
    Handle data;                   // the dataset of the file being written
    std::vector<std::byte> bytes;  // taken in and not yet written
    std::uint64_t buffered = 0;    // rows in `bytes`
    std::uint64_t written = 0;     // rows in the dataset
  };
  struct Stream {
    std::string name;
    const MessageType* type;
    PackedLayout layout;
    Rows messages;
    std::vector<Rows> arrays;            // by index into the layout's arrays
    std::vector<PackedLayout> elements;  // of each
  };
  enum class State { declaring, writing, closed };

  [[noreturn]] void fail(const char* doing) const;
  /// Makes an empty recording at `path`.
  Handle make_file(const std::filesystem::path& path, bool final) const;
  void make_groups(hid_t file, const Stream& stream) const;
  Handle make_data(hid_t file, const Rows& rows, bool final) const;
  void start();
  /// Takes the elements of an array in; returns the number of the first.
  static std::uint64_t add_elements(Rows& rows, const PackedLayout& layout, std::size_t stride,
                                    const SharedBytes& elements);
  /// Asks the file system for room behind the file's end for so many bytes more, before HDF5 takes them in. Throws
  /// RunError where it has none: a write that fails half way would leave a file that cannot be opened.
  void reserve(std::uint64_t more);
  void write_buffered(Stream& stream);
  void write_rows(Rows& rows);
  void copy_rows(hid_t from, hid_t to, Rows& rows) const;
  void rewrite_compressed(const std::filesystem::path& to);

  std::filesystem::path path_;
  RecordingHeader header_;
  std::vector<Stream> streams_;
  RecordingLock lock_;
  Handle file_;
  std::uint64_t unflushed_ = 0;  // bytes that the next flush may write, at most
  State state_ = State::declaring;
  std::chrono::steady_clock::time_point flushed_;
};

}  // namespace tactor
