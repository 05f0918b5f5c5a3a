// One tree from a graph file, the files it extends and the values of the command line.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "framework/graph/spec.hpp"
#include "framework/yaml/file_finder.hpp"

namespace tactor {

/// The tree of `file` over those it extends, under the overrides, the later of them over the earlier. Every value keeps
/// the place it came from; one from the command line has the option as its file and line 0. The registry knows the
/// types of the nodes to which names of overlays are bound. `read` becomes the files that were read, in that order,
/// each once and without symbolic links.
std::optional<Tree> compose(const std::filesystem::path& file, const Overrides& overrides, Registry& registry,
                            Diagnostics& diagnostics, std::vector<std::filesystem::path>& read);

/// Looks for a file that is laid over the graph of that file.
FileSearch find_over(const std::filesystem::path& over, const std::filesystem::path& graph);

}  // namespace tactor
