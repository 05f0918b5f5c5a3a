// One tree from a graph file, the files it extends and the values of the command line.
#pragma once

#include <filesystem>
#include <optional>

#include "framework/graph/spec.hpp"
#include "framework/graph/yaml_tree.hpp"

namespace tactor {

/// The two ends of an edge as its text says them; empty where it is none.
struct EdgeEnds {
  std::string from;  ///< `node.port`
  std::string to;
};

/// The ends of an edge in any of its forms: `a.x -> b.y`, `{a.x -> b.y: ...}`, `{from: a.x, to: b.y, ...}`.
std::optional<EdgeEnds> edge_ends(const Tree& edge);

/// The node of `node.port`.
std::string node_of(const std::string& end);

/// The tree of `file` over those it extends, under the overrides. Every value keeps the place it came from; one from
/// the command line has the option as its file and line 0.
std::optional<Tree> compose(const std::filesystem::path& file, const Overrides& overrides, Diagnostics& diagnostics);

}  // namespace tactor
