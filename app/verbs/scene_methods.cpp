#include "app/verbs/scene_methods.hpp"

#include "framework/core/file_lookup.hpp"
#include "framework/graph/spec.hpp"
#include "framework/yaml/file_finder.hpp"

namespace tactor {

namespace fs = std::filesystem;

std::vector<ComparedGraph> scene_with_methods(const fs::path& scene, const std::vector<std::string>& methods) {
  const fs::path in_folder = find_file(scene / "scene.yaml", {""}, graph_files).file;
  const fs::path file = in_folder.empty() ? named_file(scene, graph_files) : in_folder;
  std::vector<ComparedGraph> graphs;
  for (const std::string& method : methods) {
    const fs::path beside = file.parent_path() / (method + std::string(graph_files.ending));
    if (fs::is_regular_file(beside)) {
      graphs.push_back({.file = beside});
    } else {
      const fs::path over = named_file(method, method_files);
      graphs.push_back({.file = file, .method = {over_patch(over)}, .method_name = over.stem().string()});
    }
  }
  return graphs;
}

}  // namespace tactor
