// Finds the files that YAML files and command lines name, and tells where one was looked for that is not there.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "framework/core/file_lookup.hpp"
#include "framework/yaml/yaml_tree.hpp"

namespace tactor {

/// `; looked for A, B (a folder); FOLDER holds a.yaml, b.yaml; did you mean "a.yaml"?`: where a search looked in vain,
/// and the files of the same ending that are there, at most 40 of a folder.
std::string looked_for(const FileSearch& search);

/// The file of a command line, from the folder of the command. Throws InputError where there is none.
std::filesystem::path named_file(const std::filesystem::path& name, const FileKind& kind);

/// Finds what the values of a graph or study name: beside the file that holds the value, beside the graph or study,
/// then as find_file does.
class FileFinder {
 public:
  /// `folder` is that of the graph or study.
  explicit FileFinder(std::filesystem::path folder) : folder_(std::move(folder)) {}

  /// The absolute path of the file that the value names; nothing, with an error, where there is none.
  [[nodiscard]] std::optional<std::filesystem::path> find(const Tree& tree, const std::string& path,
                                                          const FileKind& kind, Diagnostics& diagnostics) const;

 private:
  std::filesystem::path folder_;
};

}  // namespace tactor
