#include "framework/graph/files.hpp"

#include <algorithm>

#include "framework/yaml/nearby_files.hpp"

namespace tactor {

namespace fs = std::filesystem;

std::optional<fs::path> FileFinder::find(const Tree& tree, const std::string& path, Diagnostics& diagnostics) const {
  if (!tree.is_scalar() || tree.text.empty()) {
    diagnostics.error(tree.place, path + ": expected the path of a file, found " + describe(tree));
    return std::nullopt;
  }
  const fs::path named(tree.text);
  std::vector<fs::path> folders;
  if (named.is_absolute()) {
    folders.emplace_back();
  } else {
    // A text from the command line has no line, and no folder of its own.
    if (tree.place.line > 0) folders.push_back(fs::path(tree.place.file).parent_path());
    folders.push_back(graph_folder_);
    folders.insert(folders.end(), folders_.begin(), folders_.end());
  }
  std::vector<std::string> looked;
  std::vector<fs::path> tried;
  std::error_code error;
  for (const fs::path& folder : folders) {
    fs::path absolute = fs::absolute(folder / named, error).lexically_normal();
    const fs::file_status status = fs::status(absolute, error);
    if (fs::is_regular_file(status)) return absolute;
    tried.push_back(absolute);
    const std::string note = absolute.string() + (fs::is_directory(status) ? " (a folder)" : "");
    if (std::find(looked.begin(), looked.end(), note) == looked.end()) looked.push_back(note);
  }
  std::string places;
  for (const std::string& note : looked) places += (places.empty() ? "" : ", ") + note;
  diagnostics.error(tree.place, path + ": expected a file that exists, found " + describe(tree) + "; looked for " +
                                    places + nearby_files(tried));
  return std::nullopt;
}

}  // namespace tactor
