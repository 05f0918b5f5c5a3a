// What this program was built from, as every result tells it.
#pragma once

#include <string>

namespace tactor {

/// The functions of the library libtactor_build.so, which is the only part of a build that a commit alone changes.
struct BuildLibrary {
  const char* commit;    ///< of git, 40 hexadecimal digits; `unknown` without a clone
  bool is_dirty;         ///< a file that git knows had changes that were not committed
  const char* compiler;  ///< `GNU 12.2.0`
  const char* flags;     ///< for C++, without those for warnings
};

/// The file of that library; it is among the plugins, and computes nothing.
inline constexpr const char* build_library_file = "libtactor_build.so";

/// What the build tells of itself; the commit is `unknown` in an installation that lacks the library. Loads it once.
const BuildLibrary& build_library();

/// `0.2.0 (commit 0123456789ab, dirty)`, for `tactor --version`.
std::string version_text();

}  // namespace tactor

/// The one symbol that libtactor_build.so exports.
extern "C" const tactor::BuildLibrary* tactor_build_library();
