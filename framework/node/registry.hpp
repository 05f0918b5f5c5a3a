// The registry of node types: libraries are loaded by the prefix of a type name, when a graph names it.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "framework/node/info.hpp"

namespace tactor {

/// Holds the declarations of the node types whose libraries are loaded. A type `prediction.ar` lives in the library
/// `libtactor_prediction.so`, looked for in the folders of TACTOR_NODE_PATH (separated by colons) and then in the given
/// ones. Libraries stay loaded until the process ends, because nodes hold code of theirs.
class Registry {
 public:
  explicit Registry(std::vector<std::filesystem::path> folders);

  /// Adds a node type; a second one of the same name aborts. Throws InputError where a parameter has the name of a key
  /// that every node has, or where the lane is `realtime` and the type is not made for it.
  void add(NodeInfo info);
  /// Makes a type known without a library, for tests and for programs that carry their own nodes.
  template <class N>
  void add() {
    add(N::declare());
  }

  /// The declaration of `type`, loading its library where needed; null where there is none.
  /// Throws InputError where the library is there and cannot be used.
  const NodeInfo* find(std::string_view type);

  /// Loads every library there is; for listings and for the nearest names in error texts.
  void load_all();

  /// The types known so far, by name.
  [[nodiscard]] std::vector<const NodeInfo*> types() const;
  /// Why the types of `prefix` are not known: where its library was looked for, and whether this build leaves it out.
  [[nodiscard]] std::string why_missing(std::string_view prefix) const;
  /// The prefixes whose libraries are loaded.
  [[nodiscard]] std::vector<std::string> loaded_libraries() const;
  /// The folders that are searched, in order.
  [[nodiscard]] const std::vector<std::filesystem::path>& folders() const { return folders_; }

 private:
  void load(const std::string& prefix, const std::filesystem::path& file);

  std::vector<std::filesystem::path> folders_;
  std::map<std::string, NodeInfo, std::less<>> types_;
  std::map<std::string, bool, std::less<>> libraries_;  // prefix -> found
};

/// The folder of node libraries beside the running program (its own, or ../lib/tactor where that exists).
std::vector<std::filesystem::path> default_node_folders();

}  // namespace tactor

/// What a node library exports: `TACTOR_NODES(registry) { registry.add<MyNode>(); }` in one of its source files.
/// The version keeps a library built against other headers out: it grows with every change of what the libraries and
/// the program share (messages, ports, declarations, the scene).
#define TACTOR_NODE_ABI 5
// NOLINTBEGIN(bugprone-macro-parentheses): a parameter name cannot stand in parentheses.
#define TACTOR_NODES(registry)                                              \
  extern "C" __attribute__((visibility("default"))) int tactor_node_abi() { \
    return TACTOR_NODE_ABI;                                                 \
  }                                                                         \
  extern "C" __attribute__((visibility("default"))) void tactor_register_nodes(::tactor::Registry& registry)
// NOLINTEND(bugprone-macro-parentheses)
