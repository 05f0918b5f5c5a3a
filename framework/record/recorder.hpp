// Recordings of runs without their file format: what writes them, what reads them, and the library that does both.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "framework/core/message.hpp"
#include "framework/core/message_batch.hpp"
#include "framework/record/table.hpp"

namespace tactor {

/// What a recording says of its run.
struct RecordingHeader {
  std::string graph;       ///< the resolved graph, YAML
  std::uint64_t seed = 0;  ///< of the run
  std::string version;     ///< of tactor
  /// When, where and by what it was made, as JSON; empty: not told. All else in a recording is the same for the same
  /// run.
  std::string provenance{};
};

/// Writes one recording. Used by one thread at a time.
///
/// While the run lasts the file can be read by others and survives the death of the process up to the last flush;
/// `close` then rewrites it compressed, so that its bytes depend on what was recorded and not on when it was flushed.
/// Every function throws RunError, with the path, where the disk refuses.
class Recorder {
 public:
  virtual ~Recorder() = default;
  /// Adds the stream `name` (`node.port`, each once, no slash) and returns its index; only before the first `write`.
  /// `type` outlives the recorder.
  virtual std::size_t add_stream(std::string_view name, const MessageType& type) = 0;
  /// Takes in a message, a struct of the stream's type. Flushes when the last flush is half a second of wall time ago;
  /// a caller that may pause longer calls `flush` itself.
  virtual void write(std::size_t stream, const Stamp& stamp, const void* payload) = 0;
  /// Hands everything taken in so far to the operating system.
  virtual void flush() = 0;
  /// Finishes the file; nothing is written afterwards. Without it the file stays readable and counts as incomplete.
  virtual void close() = 0;
};

/// A stream of a recording.
struct RecordedStream {
  std::string name;         ///< `node.port`
  MessageType type;         ///< as the file describes it
  std::uint64_t count = 0;  ///< messages
};

/// Reads one recording. Every function throws InputError, with the path, where the file is damaged.
class RecordingReader {
 public:
  virtual ~RecordingReader() = default;
  [[nodiscard]] virtual const std::filesystem::path& path() const = 0;
  [[nodiscard]] virtual const RecordingHeader& header() const = 0;
  /// False where the run ended without closing its recording.
  [[nodiscard]] virtual bool complete() const = 0;
  /// The streams by name.
  [[nodiscard]] virtual const std::vector<RecordedStream>& streams() const = 0;
  /// Adds `count` messages from the `first` on to `out`, whose type is that of the stream.
  virtual void read(std::size_t stream, std::uint64_t first, std::uint64_t count, MessageBatch& out) = 0;

  /// The index of the stream `name`; throws InputError naming those there are.
  [[nodiscard]] std::size_t find(std::string_view name) const;
};

/// The functions of the recording library.
struct RecordLibrary {
  /// Creates a recording; one that was there is replaced. Throws InputError where that is not possible.
  std::unique_ptr<Recorder> (*create)(const std::filesystem::path& path, const RecordingHeader& header);
  /// Opens a recording, finished or not. Throws InputError where the file is missing, damaged or no recording.
  std::unique_ptr<RecordingReader> (*open)(const std::filesystem::path& path);
  /// Clears the marks that a killed run leaves in its file and that keep other HDF5 programs from opening it plainly.
  /// Throws InputError where a run is still writing it.
  void (*repair)(const std::filesystem::path& path);
  /// Writes a table; one that was there is replaced. Throws RunError where the disk refuses.
  void (*write_table)(const std::filesystem::path& path, const TableFile& table);
};

/// Loads libtactor_record.so, once, from the folder of the program, ../lib or the folder of the framework's library.
/// Throws InputError where it is not there: then the build has no HDF5.
const RecordLibrary& load_record_library();

}  // namespace tactor

/// The one symbol that libtactor_record.so exports; null where the caller is of another build.
extern "C" const tactor::RecordLibrary* tactor_record_library();
