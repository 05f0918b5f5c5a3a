#include "framework/yaml/file_finder.hpp"

#include <algorithm>
#include <system_error>

#include "framework/yaml/yaml_values.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t most_names = 40;

fs::path as_absolute(const fs::path& file) {
  std::error_code ignored;
  return fs::absolute(file, ignored).lexically_normal();
}

std::vector<std::string> names_in(const fs::path& folder, const fs::path& ending) {
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

/// What lies in the folders of these files, and the name that is nearest to theirs.
std::string nearby(const std::vector<fs::path>& looked) {
  const std::string wanted = looked.front().filename().string();
  const auto ends =
      std::find_if(looked.begin(), looked.end(), [](const fs::path& file) { return file.has_extension(); });
  const fs::path ending = ends == looked.end() ? fs::path(".yaml") : ends->extension();
  std::string text;
  std::vector<std::string> all;
  std::vector<fs::path> seen;
  for (const fs::path& file : looked) {
    const fs::path folder = file.parent_path();
    if (std::find(seen.begin(), seen.end(), folder) != seen.end()) continue;
    seen.push_back(folder);
    std::vector<std::string> names = names_in(folder, ending);
    if (names.empty()) continue;
    all.insert(all.end(), names.begin(), names.end());
    const std::size_t more = names.size() - std::min(names.size(), most_names);
    names.resize(names.size() - more);
    text += "; " + folder.string() + " holds " + list_of(names);
    if (more > 0) text += " and " + std::to_string(more) + " more";
  }
  const std::string full = looked.front().has_extension() ? wanted : wanted + ending.string();
  // Another ending, or another folder, is near too.
  if (std::find(all.begin(), all.end(), full) != all.end()) return text + "; did you mean \"" + full + "\"?";
  return text + did_you_mean(full, all);
}

}  // namespace

std::string looked_for(const FileSearch& search) {
  std::vector<fs::path> files;
  std::string text;
  for (const fs::path& tried : search.tried) {
    const fs::path file = as_absolute(tried);
    if (std::find(files.begin(), files.end(), file) != files.end()) continue;
    files.push_back(file);
    std::error_code ignored;
    text += (text.empty() ? "; looked for " : ", ") + file.string() +
            (fs::is_directory(file, ignored) ? " (a folder)" : "");
  }
  return files.empty() ? text : text + nearby(files);
}

fs::path named_file(const fs::path& name, const FileKind& kind) {
  const FileSearch search = find_file(name, {""}, kind);
  if (!search.file.empty()) return search.file;
  std::string hint;
  const bool is_graph = kind.folder == graph_files.folder && kind.part.empty();
  if (is_graph && name.has_parent_path() && !find_file(name.stem(), {""}, method_files).file.empty()) {
    const std::string scene = (name.parent_path() / "scene").string(), method = name.stem().string();
    hint = "; " + method + " is a method, which can be laid over a scene: " + scene + " --over " + method;
  }
  throw InputError(name.string() + ": expected " + kind.noun + " that exists" + looked_for(search) + hint);
}

std::optional<fs::path> FileFinder::find(const Tree& tree, const std::string& path, const FileKind& kind,
                                         Diagnostics& diagnostics) const {
  if (!tree.is_scalar() || tree.text.empty()) {
    diagnostics.error(tree.place, path + ": expected the path of " + kind.noun + ", found " + describe(tree));
    return std::nullopt;
  }
  std::vector<fs::path> beside;
  // A text from the command line has no line, and no folder of its own.
  if (tree.place.line > 0) beside.push_back(fs::path(tree.place.file).parent_path());
  beside.push_back(folder_);
  const FileSearch search = find_file(tree.text, beside, kind);
  if (!search.file.empty()) return as_absolute(search.file);
  diagnostics.error(tree.place,
                    path + ": expected " + kind.noun + " that exists, found " + describe(tree) + looked_for(search));
  return std::nullopt;
}

}  // namespace tactor
