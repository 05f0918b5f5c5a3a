// A temporary folder that is removed with its owner.
#pragma once

#include <stdlib.h>

#include <filesystem>
#include <string>
#include <system_error>

#include "framework/core/check.hpp"

namespace tactor {

/// Makes a folder that no other user can predict or read, and removes it with its content. Throws RunError if none can
/// be made.
class TemporaryFolder {
 public:
  /// On this machine's own disk, in TMPDIR or /tmp.
  TemporaryFolder() : TemporaryFolder(own_disk(), "tactor-") {}
  /// In `parent`, by a name that begins so.
  TemporaryFolder(const std::filesystem::path& parent, const std::string& begin) {
    std::string name = (parent / (begin + "XXXXXX")).string();
    if (mkdtemp(name.data()) == nullptr) throw RunError("cannot make a temporary folder " + name);
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  /// TMPDIR may name a folder of another machine.
  static std::filesystem::path own_disk() {
    std::error_code error;
    std::filesystem::path path = std::filesystem::temp_directory_path(error);
    if (error) throw RunError("cannot make a temporary folder in TMPDIR, or /tmp: " + error.message());
    return path;
  }

  std::filesystem::path path_;
};

}  // namespace tactor
