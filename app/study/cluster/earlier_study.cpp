#include "app/study/cluster/earlier_study.hpp"

#include <fmt/format.h>

#include <array>
#include <vector>

#include "app/output.hpp"
#include "app/study/cluster/cluster_plan.hpp"
#include "framework/core/check.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

constexpr const char* table_name = "study.sqlite";
constexpr std::array table_endings{"", "-wal", "-shm"};  // of SQLite's files

fs::path table_of(const fs::path& out, const char* ending) {
  return (out / table_name).string() + ending;
}

std::vector<fs::path> files_in(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) files.push_back(entry.path());
  return files;
}

/// The files of a study in its folder but for the cache, and `aside`.
std::vector<fs::path> files_of(const ClusterFolder& folder, const fs::path& aside) {
  std::vector<fs::path> files = files_in(folder.path());
  std::erase_if(files, [&](const fs::path& file) { return file == folder.cache() || file == aside; });
  return files;
}

}  // namespace

void clear_study_folder(const fs::path& out) {
  std::error_code ignored;
  for (const fs::path& file : files_of(ClusterFolder(out), {})) fs::remove_all(file, ignored);
  for (const char* ending : table_endings) fs::remove(table_of(out, ending), ignored);
}

EarlierStudy::EarlierStudy(fs::path out) : out_(std::move(out)), aside_(ClusterFolder(out_).path() / "earlier") {
  const ClusterFolder folder(out_);
  try {
    // Of a command that was killed between, whose study was overwritten since.
    if (folder.is_there()) fs::remove_all(aside_);
    fs::create_directories(aside_);
    for (const fs::path& file : files_of(folder, aside_)) fs::rename(file, aside_ / file.filename());
    for (const char* ending : table_endings) {
      if (const fs::path table = table_of(out_, ending); fs::exists(table))
        fs::rename(table, aside_ / table.filename());
    }
  } catch (const fs::filesystem_error& error) {
    throw RunError(fmt::format("{}: the earlier study could not be kept aside: {}", aside_.string(), error.what()));
  }
}

EarlierStudy::~EarlierStudy() {
  std::error_code error;
  if (is_dropped_) {
    fs::remove_all(aside_, error);
    return;
  }
  const ClusterFolder folder(out_);
  for (const fs::path& file : files_of(folder, aside_)) fs::remove_all(file, error);
  for (const fs::path& file : files_in(aside_)) {
    const bool is_table = file.filename().string().starts_with(table_name);
    fs::rename(file, (is_table ? out_ : folder.path()) / file.filename(), error);
    if (error) tell_note(fmt::format("the earlier study stays in {}: {}", aside_.string(), error.message()));
  }
  fs::remove(aside_, error);  // only where it is empty
}

void EarlierStudy::drop() {
  is_dropped_ = true;
}

}  // namespace tactor
