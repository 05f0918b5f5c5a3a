// Opens the files that users name for reading: graphs, studies, profiles, meshes, tables, recordings, firmware.
#pragma once

#include <cstdint>
#include <filesystem>
#include <new>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>

#include "framework/core/check.hpp"
#include "framework/core/file_descriptor.hpp"

namespace tactor {

/// A file open for reading, or why there is none: `there is no such file`, `expected a file, found a pipe; ...`.
struct InputFile {
  FileDescriptor file;
  std::uint64_t size = 0;  ///< bytes when it was opened
  std::string error;       ///< without the path; empty if the file is open
  bool is_missing = false;
  std::string found;  ///< what stands there instead of a file: `a folder`, `a pipe; ...`

  /// Reads the next bytes, at most `most`; 0 at the end of the file. Nothing, with `error`, where the disk refuses.
  std::optional<std::size_t> read_some(char* bytes, std::size_t most);

  /// Reads all bytes; false, with `error`, where there are more than `most` or the disk refuses.
  bool read(std::string& bytes, std::uint64_t most);
};

/// Opens a regular file. Anything else is refused before it is opened, because a pipe without a writer would make the
/// program wait for ever, and a terminal or device would be read as if it were a file.
InputFile open_input(const std::filesystem::path& path);

/// The same; throws InputError, `PATH: why`.
FileDescriptor open_input_file(const std::filesystem::path& path);

/// Collects the paths of all files that open_input opens in this process while it lives. These files must go along to
/// another machine that is to read them. One at a time, on the thread that reads.
class InputLog {
 public:
  InputLog();
  ~InputLog();
  InputLog(const InputLog&) = delete;
  InputLog& operator=(const InputLog&) = delete;
  /// Absolute and without symbolic links.
  [[nodiscard]] const std::set<std::filesystem::path>& files() const { return files_; }

 private:
  friend InputFile open_input(const std::filesystem::path& path);
  std::set<std::filesystem::path> files_;
};

/// All bytes of a file that has no more than `most`. Throws InputError, `PATH: why`.
std::string read_input_file(const std::filesystem::path& path, std::uint64_t most);

/// The InputError for a file that needs more memory than there is.
InputError out_of_memory_for(const std::filesystem::path& path);

/// Returns the result of `read()`. If memory runs out, throws InputError with the file and its size.
template <class Read>
auto within_memory(const std::filesystem::path& path, Read read) {
  try {
    return read();
  } catch (const std::bad_alloc&) {
  } catch (const std::length_error&) {
  }
  throw out_of_memory_for(path);
}

}  // namespace tactor
