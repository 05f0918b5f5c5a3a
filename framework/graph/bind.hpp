// Binds the names that a file uses for nodes of the graph below it to the nodes that are there.
#pragma once

#include <filesystem>
#include <functional>

#include "framework/node/info.hpp"
#include "framework/yaml/yaml_tree.hpp"

namespace tactor {

/// The declaration of a node of a tree by its type; null where the node says no type that is known.
using TypeOfNode = std::function<const NodeInfo*(const TreeEntry& node)>;

/// Lays `child` over `parent` as merge_graph does. Before that, each name in the child's map `bind` becomes the name of
/// a node of the parent: the one that the entry names, else the one of the same name, else the only one of the role
/// that the entry says. A port at such a node that has no port of that name and the type of the edge's other end
/// becomes the only port of that type. With `optional`, a name without node goes with all that names it, and an edge
/// without port goes alone. An entry of `nodes` with a type is a node of the child: without a node of its name below,
/// it takes the place of the only node of the role whose connected ports it has, and is a new node where there is none.
/// Over a file that is no graph yet (one with neither a scene nor a duration, or with names of its own to bind), the
/// names stay to be bound later. False, with errors, where a name cannot be bound.
bool lay_over(Tree& parent, Tree child, const TypeOfNode& type_of, Diagnostics& diagnostics);

/// False, with an error, where names of the graph that `file` made still wait for another one to be bound to.
bool is_bound(const Tree& graph, const std::filesystem::path& file, Diagnostics& diagnostics);

}  // namespace tactor
