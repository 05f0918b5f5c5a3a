#include "framework/yaml/nearby_files.hpp"

#include <algorithm>
#include <system_error>

#include "framework/yaml/diagnostics.hpp"
#include "framework/yaml/yaml_values.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t most_names = 40;

std::vector<std::string> files_of(const fs::path& folder, const fs::path& ending) {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    std::error_code ignored;
    if (entry.path().extension() == ending && entry.is_regular_file(ignored)) {
      names.push_back(entry.path().filename().string());
    }
  }
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace

std::string nearby_files(const std::vector<fs::path>& looked) {
  if (looked.empty()) return {};
  const std::string wanted = looked.front().filename().string();
  const fs::path ending = looked.front().has_extension() ? looked.front().extension() : fs::path(".yaml");
  std::string text;
  std::vector<std::string> all;
  std::vector<fs::path> seen;
  for (const fs::path& file : looked) {
    const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
    if (std::find(seen.begin(), seen.end(), folder) != seen.end()) continue;
    seen.push_back(folder);
    std::vector<std::string> names = files_of(folder, ending);
    if (names.empty()) continue;
    all.insert(all.end(), names.begin(), names.end());
    const std::size_t more = names.size() - std::min(names.size(), most_names);
    names.resize(names.size() - more);
    text += "; " + folder.string() + " holds " + list_of(names);
    if (more > 0) text += " and " + std::to_string(more) + " more";
  }
  const std::string full = looked.front().has_extension() ? wanted : wanted + ending.string();
  // A name without its ending is near to the file it stands for.
  if (std::find(all.begin(), all.end(), full) != all.end()) return text + "; did you mean \"" + full + "\"?";
  return text + did_you_mean(full, all);
}

}  // namespace tactor
