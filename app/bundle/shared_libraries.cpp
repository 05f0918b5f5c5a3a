#include "app/bundle/shared_libraries.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <sstream>
#include <string>
#include <string_view>

#include "app/command_output.hpp"
#include "framework/core/check.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

/// glibc and its loader, which work together in one version alone.
constexpr std::array<std::string_view, 12> of_c_library{"ld-linux",     "libc.so",       "libm.so",   "libdl.so",
                                                        "librt.so",     "libpthread.so", "libnsl.so", "libutil.so",
                                                        "libresolv.so", "libmvec.so",    "libanl.so", "linux-vdso"};

bool is_of_c_library(const std::string& name) {
  return std::any_of(of_c_library.begin(), of_c_library.end(),
                     [&](std::string_view begin) { return name.starts_with(begin); });
}

}  // namespace

std::set<fs::path> shared_libraries(const std::vector<fs::path>& binaries) {
  std::set<fs::path> libraries;
  for (const fs::path& binary : binaries) {
    // `	libfmt.so.9 => /usr/lib/libfmt.so.9 (0x...)`, `	libx.so => not found`
    std::istringstream lines(output_of({"ldd", binary.string()}));
    for (std::string line; std::getline(lines, line);) {
      std::istringstream words(line);
      std::string name, arrow, file;
      words >> name >> arrow >> file;
      if (arrow != "=>" || is_of_c_library(fs::path(name).filename().string())) continue;
      if (!file.starts_with('/')) throw RunError(fmt::format("{} needs {}, which is not found", binary.string(), name));
      // The name is what the loader looks for, whatever the file behind a link is called.
      libraries.insert(fs::path(file).parent_path() / name);
    }
  }
  return libraries;
}

}  // namespace tactor
