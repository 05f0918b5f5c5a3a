#include "app/results_folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <span>
#include <string_view>
#include <thread>

#include "app/interruption.hpp"
#include "app/output.hpp"
#include "framework/core/check.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

constexpr int most_numbers = 10'000;  // of folders beside each other
constexpr const char* lock_name = ".tactor.lock";
constexpr const char* study_table = "study.sqlite";

/// What runs and comparisons leave, what only they can have left first. A study's table, which --resume goes on with,
/// is not theirs.
constexpr std::array<std::string_view, 11> left_by_runs{
    "summary.json",       "recording.h5",        "compare.sqlite", "compare.json",  "report.html", "compare.sqlite-wal",
    "compare.sqlite-shm", "compare.sqlite.lock", "graph.yaml",     "latencies.csv", "flight.ring"};
constexpr std::size_t telling = 4;  // of left_by_runs: what tells that a command has left its results here

/// The first result of a run or a comparison that lies in the folder; empty where none does.
std::string found_in(const fs::path& folder, std::size_t names = left_by_runs.size()) {
  for (const std::string_view name : std::span(left_by_runs).first(names)) {
    if (is_taken(folder / name)) return std::string(name);
  }
  return {};
}

bool holds_results(const fs::path& folder) {
  return !found_in(folder).empty() || is_taken(folder / study_table);
}

/// `out/duck` with a number behind: `out/duck_2`.
fs::path numbered(const fs::path& folder, int number) {
  if (number == 1) return folder;
  fs::path path = folder;
  return path.replace_filename(fmt::format("{}_{}", folder.filename().string(), number));
}

std::string no_number_is_free(const fs::path& chosen) {
  return fmt::format("{}: expected a free number up to {}, found none; name another folder by --out", chosen.string(),
                     most_numbers);
}

[[noreturn]] void refuse(const fs::path& path, const std::string& what, const std::string& found) {
  throw InputError(fmt::format("--out {}: expected {}, found {}; --overwrite replaces it, another --out keeps both",
                               path.string(), what, found));
}

}  // namespace

FileLock::FileLock(const fs::path& file, const std::string& what) {
  file_ = FileDescriptor(open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666));
  if (!file_) throw RunError(fmt::format("cannot write {}: {}", file.string(), std::strerror(errno)));
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(1);
  while (!lock_.take(file_.number(), file)) {
    if (is_interrupted()) throw RunError("interrupted");
    if (std::chrono::steady_clock::now() > until) {
      throw InputError(what + " that no other program writes, found another tactor writing it" + lock_.holder());
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

fs::path results_folder(const fs::path& chosen, const ResultsRequest& request) {
  if (request.out || request.overwrite) {
    const fs::path folder = request.out.value_or(chosen);
    if (is_taken(folder / study_table)) {
      throw InputError(
          fmt::format("--out {}: expected a folder for this command, found the runs of a study; name "
                      "another --out",
                      folder.string()));
    }
    const std::string found = found_in(folder);
    if (!found.empty() && !request.overwrite) refuse(folder, "a folder without results", found);
    return folder;
  }
  for (int number = 1; number <= most_numbers; ++number) {
    if (const fs::path folder = numbered(chosen, number); !holds_results(folder)) return folder;
  }
  throw InputError(no_number_is_free(chosen));
}

ResultsFolder::ResultsFolder(const fs::path& chosen, const ResultsRequest& request) {
  const auto lock = [&] {
    lock_.emplace(path_ / lock_name, fmt::format("--out {}: expected a folder", path_.string()));
  };
  if (request.out || request.overwrite) {
    path_ = make_folder(results_folder(chosen, request));
    lock();
    // Another command may have ended there in this moment.
    path_ = results_folder(chosen, request);
    return;
  }
  for (int number = 1; number <= most_numbers; ++number) {
    path_ = numbered(chosen, number);
    if (holds_results(path_)) continue;
    make_folder(path_);
    try {
      lock();
    } catch (const InputError&) {
      continue;  // another command has taken it and has not written yet
    }
    if (!holds_results(path_)) return;
    lock_.reset();
  }
  throw InputError(no_number_is_free(chosen));
}

void ResultsFolder::refuse_to_replace(const fs::path& input) const {
  for (const std::string_view name : left_by_runs) {
    std::error_code ignored;
    if (!fs::equivalent(input, path_ / name, ignored)) continue;
    throw InputError(fmt::format("--out {}: expected a folder other than that of {}, which the results would replace",
                                 path_.string(), input.string()));
  }
}

void ResultsFolder::clear() const {
  // Without a result of ours, files of the same names are the user's.
  if (found_in(path_, telling).empty()) return;
  std::error_code ignored;
  remove_link(path_ / "costs");
  for (fs::directory_iterator it(path_ / "costs", ignored), end; !ignored && it != end; it.increment(ignored)) {
    std::error_code of_file;
    if (it->path().extension() == ".txt") fs::remove(it->path(), of_file);
  }
  // A folder goes where it is empty.
  for (const std::string_view name : left_by_runs) fs::remove(path_ / name, ignored);
}

void refuse_results_of_runs(const fs::path& folder) {
  const std::string found = found_in(folder, telling);
  if (found.empty()) return;
  throw InputError(
      fmt::format("--out {}: expected a folder for a study, found {} of another command; name another --out",
                  folder.string(), found));
}

fs::path results_file(const fs::path& chosen, const std::vector<std::string>& beside, const ResultsRequest& request) {
  const auto found = [&beside](const fs::path& file) -> std::string {
    if (is_taken(file)) return file.filename().string();
    for (const std::string& ending : beside) {
      const fs::path other = fs::path(file).replace_extension(ending);
      if (is_taken(other)) return other.filename().string();
    }
    return {};
  };
  if (request.out || request.overwrite) {
    const fs::path file = request.out.value_or(chosen);
    const std::string there = found(file);
    if (!request.overwrite && !there.empty()) refuse(file, "files that are not there yet", there);
    return file;
  }
  for (int number = 1; number <= most_numbers; ++number) {
    fs::path file = chosen;
    if (number > 1) {
      file.replace_filename(fmt::format("{}_{}{}", chosen.stem().string(), number, chosen.extension().string()));
    }
    if (found(file).empty()) return file;
  }
  throw InputError(no_number_is_free(chosen));
}

}  // namespace tactor
