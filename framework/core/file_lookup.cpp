#include "framework/core/file_lookup.hpp"

#include <algorithm>
#include <cstdlib>
#include <set>
#include <sstream>
#include <system_error>

#include "framework/core/installation.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

/// What is no file but could be opened is found too: whoever opens it tells what it is.
bool is_there(const fs::path& file) {
  std::error_code ignored;
  const fs::file_status status = fs::status(file, ignored);
  return fs::exists(status) && !fs::is_directory(status);
}

}  // namespace

std::vector<fs::path> folders_of(const FileKind& kind) {
  std::vector<fs::path> folders;
  const auto add = [&](const fs::path& folder) {
    if (!kind.part.empty()) folders.push_back(folder / kind.part);
    folders.push_back(folder);
  };
  const char* variable = kind.variable.empty() ? nullptr : std::getenv(kind.variable.c_str());
  std::istringstream parts(variable == nullptr ? "" : variable);
  for (std::string part; std::getline(parts, part, ':');) {
    if (!part.empty()) add(part);
  }
  if (kind.folder.empty()) return folders;
  add(installation_prefix() / kind.folder);
  add(installation_prefix() / "share" / "tactor" / kind.folder);
  return folders;
}

FileSearch find_file(const fs::path& name, const std::vector<fs::path>& beside, const FileKind& kind) {
  FileSearch search;
  const auto look = [&](const fs::path& folder, const fs::path& wanted) {
    const fs::path file = (folder / wanted).lexically_normal();
    if (std::find(search.tried.begin(), search.tried.end(), file) != search.tried.end()) return false;
    search.tried.push_back(file);
    if (!is_there(file)) return false;
    search.file = file;
    return true;
  };
  const bool is_whole = kind.ending.empty() || name.extension() == kind.ending;
  fs::path whole = name;
  if (!is_whole) whole += kind.ending;
  const std::vector<fs::path> near = name.is_absolute() ? std::vector<fs::path>{""} : beside;
  for (const fs::path& folder : near) {
    if (look(folder, name)) return search;
  }
  if (name.is_absolute()) return search;
  for (const fs::path& folder : folders_of(kind)) {
    if (look(folder, whole)) return search;
  }
  // Last, so that a file beside a study hides nothing that is installed.
  for (const fs::path& folder : near) {
    if (look(folder, whole)) return search;
  }
  return search;
}

std::vector<std::string> names_in_folders(const fs::path& file_name, const FileKind& kind) {
  std::set<std::string> names;
  for (const fs::path& folder : folders_of(kind)) {
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(folder, ignored)) {
      if (!entry.is_directory(ignored) || !is_there(entry.path() / file_name)) continue;
      fs::path name = entry.path().filename() / file_name;
      if (!kind.ending.empty() && name.extension() == kind.ending) name.replace_extension();
      names.insert(name.string());
    }
  }
  return {names.begin(), names.end()};
}

std::vector<fs::path> files_of(const FileKind& kind) {
  std::vector<fs::path> files;
  for (const fs::path& folder : folders_of(kind)) {
    std::error_code ignored;
    std::vector<fs::path> here;
    for (const auto& entry : fs::directory_iterator(folder, ignored)) {
      const auto same = [&](const fs::path& file) { return file.filename() == entry.path().filename(); };
      const bool fits = entry.path().extension() == kind.ending && is_there(entry.path());
      if (fits && std::none_of(files.begin(), files.end(), same)) here.push_back(entry.path());
    }
    std::sort(here.begin(), here.end());
    files.insert(files.end(), here.begin(), here.end());
  }
  return files;
}

}  // namespace tactor
