// The format of graph and study files, and what is said where a file has an older one.
#pragma once

#include <string>

#include "framework/yaml/yaml_tree.hpp"

namespace tactor {

/// What errors call a file with a graph.
inline const YamlFileKind graph_file{"a graph file", "nodes, edges, duration, ..."};

/// What this program reads and writes. Files say it as `format: 2`.
inline constexpr int file_format = 2;

/// Takes the key `format` out of a file's map. A file that has none counts as one of `file_format`; another number is
/// an error.
void take_format(Tree& file, Diagnostics& diagnostics);

/// ` is called NOW now; tactor migrate FILE rewrites it`; without the second part for what comes from the command line.
std::string renamed_text(const std::string& now, const SourceLocation& place);

}  // namespace tactor
