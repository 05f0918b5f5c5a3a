// What the command writes beside standard output: files, and standard error.
#pragma once

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include "framework/core/check.hpp"

namespace tactor {

/// Writes to standard error, which may be a terminal that has been closed: that is no reason to throw, least of all in
/// the middle of a force.
inline void tell(const std::string& text) {
  static_cast<void>(std::fputs(text.c_str(), stderr));
  static_cast<void>(std::fflush(stderr));
}

/// Writes a file whole; throws RunError where the disk refuses.
inline void write_file(const std::filesystem::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  if (!file.flush()) throw RunError("cannot write " + path.string());
}

}  // namespace tactor
