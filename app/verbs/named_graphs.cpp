#include "app/verbs/named_graphs.hpp"

#include <map>
#include <system_error>

namespace tactor {

namespace fs = std::filesystem;

std::vector<NamedGraph> graphs_by_name(const FileKind& kind) {
  std::map<std::string, fs::path> found;
  for (const fs::path& folder : folders_of(kind)) {
    std::error_code ignored;
    for (const auto& entry : fs::recursive_directory_iterator(folder, ignored)) {
      if (entry.path().extension() != kind.ending || !entry.is_regular_file(ignored)) continue;
      found.emplace(entry.path().lexically_relative(folder).replace_extension().generic_string(), entry.path());
    }
  }
  std::vector<NamedGraph> graphs;
  for (const auto& [name, file] : found) graphs.push_back({name, file});
  return graphs;
}

bool is_below(const NamedGraph& graph, std::string_view folder) {
  return graph.name.starts_with(std::string(folder) + "/");
}

}  // namespace tactor
