// Finds the files that a graph names.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "framework/yaml/yaml_tree.hpp"

namespace tactor {

/// What errors call a file with a graph.
inline const YamlFileKind graph_file{"a graph file", "nodes, edges, duration, ..."};

/// Where relative paths are looked for: beside the file that holds the text, beside the graph, then in `folders`.
class FileFinder {
 public:
  FileFinder(std::filesystem::path graph_folder, std::vector<std::filesystem::path> folders)
      : graph_folder_(std::move(graph_folder)), folders_(std::move(folders)) {}

  /// The absolute path of the regular file that the tree names; an error that says where it was looked for otherwise.
  [[nodiscard]] std::optional<std::filesystem::path> find(const Tree& tree, const std::string& path,
                                                          Diagnostics& diagnostics) const;

 private:
  std::filesystem::path graph_folder_;
  std::vector<std::filesystem::path> folders_;
};

}  // namespace tactor
