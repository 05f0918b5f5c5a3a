// A folder of the user's own with the files that the program keeps there: cache and calibrations.
#pragma once

#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "framework/core/file_descriptor.hpp"

namespace tactor {

/// Every file that the program keeps between two runs is opened through this class, so that no other user can change a
/// file that it reads, or redirect a file that it writes. The folder belongs to the (effective) user, and nobody else
/// may write it. Missing folders of its path are made with mode 0700. Links in the path are followed if they belong to
/// the user or to root. Inside the folder, no link is followed, and only regular files of the user count that nobody
/// else may write.
///
/// Where its files decide which programs are started, the folders above it count too: none may be one that every user
/// may write and whose entries every user may rename (no sticky bit). A folder that a group shares may be above it.
///
/// All members throw RunError with a message that names the path and what is wrong with it. Two processes and threads
/// may use one folder. Names are file names without a slash.
class KeptFolder {
 public:
  /// Opens the folder and makes it where it is missing.
  static KeptFolder make(const std::filesystem::path& path);
  /// What the files of the folder decide.
  enum class Decides : std::uint8_t { nothing, programs };
  /// Opens the folder; nothing where it is missing, or where `path` is empty because there is no such folder.
  static std::optional<KeptFolder> find(const std::filesystem::path& path, Decides decides = Decides::nothing);

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

  /// A file for reading; nothing where it is missing.
  [[nodiscard]] std::optional<FileDescriptor> open(const std::string& name) const;

  /// Makes or replaces a file of mode 0600, by a new one that is renamed: readers see the old bytes or the new ones,
  /// whole. What killed writers left beside is removed a day later, by the next `write`.
  void write(const std::string& name, std::initializer_list<std::string_view> parts) const;

  /// Removes a file; no error if there is none.
  void remove(const std::string& name) const;

 private:
  KeptFolder(std::filesystem::path path, FileDescriptor folder) : path_(std::move(path)), folder_(std::move(folder)) {}
  [[nodiscard]] std::string named(const std::string& name) const;
  void remove_stale_parts() const;

  std::filesystem::path path_;
  FileDescriptor folder_;
};

/// A file that tells which programs to start, and the folder that it really is in.
struct ProgramsFile {
  FileDescriptor file;
  std::filesystem::path folder;
};
/// Opens such a file, which may belong to root as well as to the user and is checked like one of a KeptFolder, and so
/// is its folder. Links of the user and of root are followed. What Tactor is installed with is trusted as its program
/// is. No file where there is none. Throws RunError as above.
ProgramsFile open_programs_file(const std::filesystem::path& path);

}  // namespace tactor
