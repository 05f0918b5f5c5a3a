// Lays one graph tree over another, as `extends` and the command line do.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "framework/yaml/yaml_tree.hpp"

namespace tactor {

/// Lays `child` over `parent`: maps merge by key, a null takes the parent's entry out, a node of another type replaces
/// the old one whole, an edge replaces the one into the same input, all else is replaced. An edge of the child
/// `into x.in -> y.in` begins at the output from which the parent feeds x.in; so a node is put between two others of
/// which one is known.
void merge_graph(Tree& parent, const Tree& child);

/// The two ends of an edge, read from its text; empty if the text is not an edge.
struct EdgeEnds {
  std::string from;  ///< `node.port`
  std::string to;
};

/// The ends of an edge in any of its forms: `a.x -> b.y`, `{a.x -> b.y: ...}`, `{from: a.x, to: b.y, ...}`.
std::optional<EdgeEnds> edge_ends(const Tree& edge);

/// Gives an edge, in whatever form, other ends.
void set_edge_ends(Tree& edge, const EdgeEnds& ends);

/// `x.in` where an edge's begin is `into x.in`.
std::optional<std::string> fed_input(const std::string& from);

/// The node of `node.port`.
std::string node_of(const std::string& end);

}  // namespace tactor
