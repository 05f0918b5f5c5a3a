// What the command writes beside standard output: files, and standard error.
#pragma once

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <system_error>
#include <utility>

#include "framework/core/check.hpp"

namespace tactor {

/// Writes to standard error, which may be a terminal that has been closed: that is no reason to throw, least of all in
/// the middle of a force.
inline void tell(const std::string& text) {
  static_cast<void>(std::fputs(text.c_str(), stderr));
  static_cast<void>(std::fflush(stderr));
}

/// Something that the user is to know and that nothing stops for, with the command's name in front.
inline void tell_note(const std::string& note) {
  tell("tactor: " + note + "\n");
}

/// `say`, but each text once; its copies remember together.
inline std::function<void(const std::string&)> once(std::function<void(const std::string&)> say) {
  return [say = std::move(say), said = std::make_shared<std::set<std::string>>()](const std::string& text) {
    if (said->insert(text).second) say(text);
  };
}

/// Whether the name is taken, be it by a link that leads nowhere: whoever wrote there would make a file elsewhere.
inline bool is_taken(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::exists(std::filesystem::symlink_status(path, ignored));
}

/// Takes a link away, so that a result is not written where it leads. A link to an open file, such as /dev/stdout,
/// stays.
inline void remove_link(const std::filesystem::path& path) {
  std::error_code ignored;
  const std::filesystem::path to = std::filesystem::read_symlink(path, ignored);
  if (!to.empty() && !to.string().starts_with("/proc/")) std::filesystem::remove(path, ignored);
}

/// Writes a file whole, in place of a link of that name; throws RunError where the disk refuses.
inline void write_file(const std::filesystem::path& path, const std::string& text) {
  remove_link(path);
  std::ofstream file(path, std::ios::binary);
  file << text;
  if (!file.flush()) throw RunError("cannot write " + path.string());
}

/// Makes the folder of the option --out; throws InputError where that cannot be.
inline std::filesystem::path make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw InputError("--out " + folder.string() + ": cannot make this folder: " + error.message());
  return folder;
}

}  // namespace tactor
