#include "devices/hardware/profile_files.hpp"

#include <algorithm>
#include <cstdlib>
#include <sstream>

#include "framework/yaml/diagnostics.hpp"

namespace tactor {

namespace fs = std::filesystem;

std::vector<fs::path> profile_folders() {
  std::vector<fs::path> folders;
  if (const char* path = std::getenv("TACTOR_PROFILE_PATH")) {
    std::istringstream parts(path);
    for (std::string part; std::getline(parts, part, ':');) {
      if (!part.empty()) folders.emplace_back(part);
    }
  }
  std::error_code ignored;
  const fs::path program = fs::read_symlink("/proc/self/exe", ignored).parent_path();
  folders.push_back(program.parent_path() / "profiles");
  folders.push_back(program.parent_path() / "share" / "tactor" / "profiles");
  return folders;
}

std::optional<fs::path> find_profile(const std::string& kind, const std::string& name) {
  std::error_code ignored;
  const bool is_path = name.find('/') != std::string::npos || name.ends_with(".yaml");
  if (is_path && fs::is_regular_file(name, ignored)) return name;
  std::string inside = name.ends_with(".yaml") ? name : name + ".yaml";
  if (!inside.starts_with(kind + "/")) inside = kind + "/" + inside;
  for (const fs::path& folder : profile_folders()) {
    if (fs::is_regular_file(folder / inside, ignored)) return folder / inside;
  }
  return std::nullopt;
}

fs::path profile_named(const std::string& kind, const std::string& name) {
  if (const auto file = find_profile(kind, name)) return *file;
  std::vector<std::string> names;
  std::string list;
  for (const fs::path& file : profile_files(kind)) {
    names.push_back(file.stem().string());
    list += (list.empty() ? "" : ", ") + names.back();
  }
  throw InputError("profile: expected the name of a profile (" + list + ") or the path of one, found \"" + name + "\"" +
                   did_you_mean(fs::path(name).stem().string(), names));
}

std::vector<fs::path> profile_files(const std::string& kind) {
  std::vector<fs::path> files;
  for (const fs::path& folder : profile_folders()) {
    std::error_code ignored;
    std::vector<fs::path> here;
    for (const auto& entry : fs::directory_iterator(folder / kind, ignored)) {
      const auto same = [&](const fs::path& file) { return file.filename() == entry.path().filename(); };
      if (entry.path().extension() == ".yaml" && std::none_of(files.begin(), files.end(), same)) {
        here.push_back(entry.path());
      }
    }
    std::sort(here.begin(), here.end());
    files.insert(files.end(), here.begin(), here.end());
  }
  return files;
}

std::string broken_profile(const fs::path& file, const std::exception& error) {
  const std::string text = error.what();
  std::string line = text.substr(0, text.find('\n'));
  if (!line.starts_with(file.string())) line = file.string() + ": " + line;
  const auto more = std::count(text.begin(), text.end(), '\n') - (text.ends_with('\n') ? 1 : 0);
  if (more > 0) line += " (and " + std::to_string(more) + " more)";
  return line;
}

}  // namespace tactor
