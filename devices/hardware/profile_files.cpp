#include "devices/hardware/profile_files.hpp"

#include <algorithm>

namespace tactor {

FileKind profiles_of(const std::string& line) {
  return {
      .noun = "a profile", .variable = "TACTOR_PROFILE_PATH", .folder = "profiles", .part = line, .ending = ".yaml"};
}

std::string broken_profile(const std::filesystem::path& file, const std::exception& error) {
  const std::string text = error.what();
  std::string line = text.substr(0, text.find('\n'));
  if (!line.starts_with(file.string())) line = file.string() + ": " + line;
  const auto more = std::count(text.begin(), text.end(), '\n') - (text.ends_with('\n') ? 1 : 0);
  if (more > 0) line += " (and " + std::to_string(more) + " more)";
  return line;
}

}  // namespace tactor
