// The graph files that a command line can name without a path.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "framework/core/file_lookup.hpp"

namespace tactor {

struct NamedGraph {
  std::string name;  ///< `bunny/local`
  std::filesystem::path file;
};

/// The files in the folders of that kind and below them, by name; of one name, the one that find_file finds.
std::vector<NamedGraph> graphs_by_name(const FileKind& kind);

/// True where the name begins with that folder.
bool is_below(const NamedGraph& graph, std::string_view folder);

}  // namespace tactor
