// What the command writes beside standard output: files, and standard error.
#pragma once

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
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

/// How urgent a line is, by the numbers of syslog.
enum class LogLevel : std::uint8_t { error = 3, warning = 4, notice = 5, info = 6 };

/// True if standard error is the journal of systemd, which takes the level of a line from `<4>` at its begin.
inline bool tells_the_journal() {
  static const bool is = [] {
    const char* const stream = std::getenv("JOURNAL_STREAM");
    struct stat file {};
    return stream != nullptr && fstat(STDERR_FILENO, &file) == 0 &&
           stream == std::to_string(file.st_dev) + ":" + std::to_string(file.st_ino);
  }();
  return is;
}

/// Writes to standard error, which may be a terminal that has been closed: that is no reason to throw, least of all in
/// the middle of a force. In the journal each line gets the level.
inline void tell(const std::string& text, LogLevel level = LogLevel::notice) {
  std::string written;
  for (std::size_t at = 0; tells_the_journal() && at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size() - 1) + 1;
    written += "<" + std::to_string(static_cast<int>(level)) + ">" + text.substr(at, end - at);
    at = end;
  }
  static_cast<void>(std::fputs(written.empty() ? text.c_str() : written.c_str(), stderr));
  static_cast<void>(std::fflush(stderr));
}

/// Something that the user is to know and that nothing stops for, with the command's name in front.
inline void tell_note(const std::string& note) {
  tell("tactor: " + note + "\n");
}

/// The same for what ends the command with an exit code other than 0.
inline void tell_failure(const std::string& failure) {
  tell("tactor: " + failure + "\n", LogLevel::error);
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
