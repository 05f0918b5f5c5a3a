// Where a command leaves its results: a place that holds none yet, and that no other command writes to meanwhile.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "framework/core/file_descriptor.hpp"
#include "framework/core/write_lock.hpp"

namespace tactor {

/// A lock on a file beside what it protects; see WriteLock.
class FileLock {
 public:
  /// Makes the file and waits a second at most for the lock, in which a process that was killed just now is gone.
  /// Throws InputError, with `what` and what was expected, where another process has it; RunError where the disk
  /// refuses, or somebody asks the command to end.
  FileLock(const std::filesystem::path& file, const std::string& what);

 private:
  FileDescriptor file_;
  WriteLock lock_;
};

/// What `--out` and `--overwrite` say.
struct ResultsRequest {
  std::optional<std::filesystem::path> out;  ///< absent: a name that the command chooses
  bool overwrite = false;
};

/// A folder for the results of one run or comparison. `--out` names a folder that must hold no results of an earlier
/// command, unless --overwrite says that they go. Without it the folder is `chosen`, or where that holds results the
/// first of chosen_2, chosen_3, ... that holds none; with --overwrite it is `chosen` itself.
class ResultsFolder {
 public:
  /// Makes and locks the folder. Nothing that is there is touched. Throws InputError where the folder cannot be made,
  /// holds results without --overwrite, or is written to by another command.
  ResultsFolder(const std::filesystem::path& chosen, const ResultsRequest& request);
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  /// Throws InputError where the results would replace `input`, a file that the command reads.
  void refuse_to_replace(const std::filesystem::path& input) const;
  /// Takes out what an earlier command left, of the names that commands write. To be called when nothing of the input
  /// can be refused any more, so that a refused command loses no results.
  void clear() const;

 private:
  std::filesystem::path path_;
  std::optional<FileLock> lock_;
};

/// The name of such a folder for a command that makes and locks it later. Nothing is made; throws InputError where the
/// folder that --out names holds results.
std::filesystem::path results_folder(const std::filesystem::path& chosen, const ResultsRequest& request);

/// Throws InputError where the folder of a study holds what a run or a comparison left.
void refuse_results_of_runs(const std::filesystem::path& folder);

/// The same rule for a file and those of the same stem that are written beside it (`beside`: their endings, `.md`):
/// `--out`, of which nothing may be there yet without --overwrite, or `chosen` with the first free number before its
/// ending. Throws InputError.
std::filesystem::path results_file(const std::filesystem::path& chosen, const std::vector<std::string>& beside,
                                   const ResultsRequest& request);

}  // namespace tactor
