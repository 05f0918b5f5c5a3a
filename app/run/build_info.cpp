#include "app/run/build_info.hpp"

#include <fmt/format.h>

#include <string_view>

#include "framework/node/plugin.hpp"

namespace tactor {

const BuildLibrary& build_library() {
  static const BuildLibrary unknown{"unknown", false, "unknown", "unknown"};
  if (!has_plugin(build_library_file)) return unknown;
  static const BuildLibrary& library = load_plugin<BuildLibrary>(build_library_file, "tactor_build_library",
                                                                 "the library that tells the commit cannot be used");
  return library;
}

std::string version_text() {
  constexpr std::size_t digits = 12;
  const BuildLibrary& build = build_library();
  return fmt::format("{} (commit {}{})", TACTOR_VERSION, std::string_view(build.commit).substr(0, digits),
                     build.is_dirty ? ", dirty" : "");
}

}  // namespace tactor
