// A folder of its own in the system's folder for such.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

#include "framework/core/check.hpp"

namespace tactor::bench {

/// Made at the beginning and gone, with what is in it, at the end. Throws RunError where it cannot be made.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "tactor_bench_XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw RunError("cannot make " + name);
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
  std::filesystem::path path_;
};

}  // namespace tactor::bench
